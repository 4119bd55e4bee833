// Classifies the equality rows of a program in stages as independent, dependent or contradictory.
#pragma once

#include <string>
#include <vector>

#include "saltus/qp/stage_qp.hpp"

namespace saltus {

enum class RowRank {
  independent,
  dependent,      ///< follows from the independent ones, the dynamics and the start
  contradictory,  ///< contradicts the independent ones, the dynamics and the start
};

/// A hard row with equal sides, or a bound with equal sides.
struct EqualityRow {
  int stage = 0;
  int group = 0;  ///< -1: bounds of an entry of v = (x, u)
  int row = 0;    ///< row of the group, or entry of v
  RowRank rank = RowRank::independent;
};
/// "row 2 of group 0 of stage 3 contradicts other equality rows".
std::string describe(const EqualityRow& row);

/// Among rows that depend on one another, numerical size decides which are independent and which
/// are dependent or contradictory. Sides that only inequalities imply are not detected. For checks
/// and messages: this function allocates.
///
/// Works backward over the stages. The next stage demands D x_next = d of its state, which adds the
/// rows D A x + D B u = d - D b to the rows of a stage. Complete pivoting eliminates the inputs: a
/// choice of input can meet the pivot rows, and the remaining rows are demands on x. At the start
/// these must hold for the given x; if x is free, they are eliminated as well.
std::vector<EqualityRow> rank_equality_rows(const qp::StageQp& qp);

}  // namespace saltus
