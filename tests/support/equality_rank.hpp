// Which equality rows of a program in stages say something new, which repeat others, which
// contradict them?
#pragma once

#include <string>
#include <vector>

#include "saltus/qp/stage_qp.hpp"

namespace saltus {

enum class RowRank {
  independent,
  dependent,      ///< follows from the independent ones, the dynamics and the start
  contradictory,  ///< cannot hold together with those
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

/// Of rows that depend on one another, some are called independent and the rest dependent (or
/// contradictory); which, is a matter of numerical size. Sides that inequalities force together are
/// not seen. For checks and messages: it allocates.
///
/// Backward over the stages: the rows of a stage are joined by what the next stage demands of its
/// state, D x_next = d, as D A x + D B u = d - D b. Inputs are eliminated with complete pivoting;
/// rows that served as pivots can be met by choice of input, those left are demands on x. At the
/// start they must hold for the given x, or are eliminated in turn if it is free.
std::vector<EqualityRow> rank_equality_rows(const StageQp& qp);

}  // namespace saltus
