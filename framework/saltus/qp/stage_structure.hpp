// Which variables and rows of a sparse program make up which stage: what a transcription knows and
// a pattern does not show.
#pragma once

#include <vector>

namespace saltus {

/// Variables and rows are indices into the sparse program; every one of them is named here once.
///
/// A variable that meets one of a later stage, in a row or in the Hessian, is carried there as an
/// additional state while that entry is in force. Rows and entries may thus join any stages;
/// nothing but the width of the stages grows. Variables with equal bounds do not exist in theirs.
struct StageStructure {
  /// What belongs to one stage.
  struct Stage {
    std::vector<int> states = {}, inputs = {};  ///< numbers of variables of the program
    /// Equality rows that define the states of the next stage, in their order: each has that state,
    /// no other one of a later stage, and nothing of later stages otherwise.
    std::vector<int> dynamics = {};
    /// Other rows, in groups with the same columns. None of their variables is of a later stage.
    std::vector<std::vector<int>> groups = {};
    /// Positions in `inputs`, each the first of `resultant_size` that act on the next
    /// states through a common resultant (see saltus::Stage). Used where no other input exists.
    std::vector<int> resultants = {};
    int resultant_size = 0;  ///< as Stage::resultant_size of the program in stages
  };
  std::vector<Stage> stages;  ///< in their order

  /// One row per state of the first stage, on that state alone: its value or its bounds.
  std::vector<int> start_rows;
  /// Variables of no stage: carried from the first stage that uses them to the last one.
  std::vector<int> globals;
  /// Variables of different stages that share one additional state, because no two of them are
  /// carried into the same stage. A variable that is not listed here has its own.
  std::vector<std::vector<int>> carried;

  /// Variables that only penalise the violation of a row: at least their lower bound, in no other
  /// row, alone in the Hessian. They are eliminated.
  struct SoftRow {
    int row = 0;                 ///< of the program
    int below = -1, above = -1;  ///< slacks of the lower and upper side, -1: no such side
  };
  std::vector<SoftRow> soft_rows;  ///< rows whose slacks are variables of the program
};

}  // namespace saltus
