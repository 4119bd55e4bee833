// Options and results of all solvers of quadratic programs.
#pragma once

#include <vector>

#include "saltus/core/clock.hpp"

namespace saltus::qp {

/// Reason why a solve ended. A solve that does not converge returns a status and never throws.
enum class QpStatus {
  optimal,
  infeasible,  ///< infeasibility certificate found: no point satisfies the rows and bounds
  unbounded,   ///< certificate found: the cost is unbounded below along a direction
  iteration_limit,
  deadline,  ///< wall-clock deadline reached; the point is the last iterate
  numerical_failure,
  invalid_problem,  ///< NaN in the data, or bounds that no value satisfies
};
/// Describes the status in one sentence.
const char* describe(QpStatus status);

/// Options of a quadratic program solver.
struct QpOptions {
  /// Starting point of a cold start.
  enum class Start {
    least_squares,  ///< needs no guess; costs about as much as one iteration
    guess,          ///< at the given point, whose active set should be close to the optimal one
  };

  Start start = Start::least_squares;  ///< start of the iteration
  double tolerance = 1e-8;   ///< largest KKT residual: stationarity, feasibility, complementarity
  int max_iterations = 100;  ///< iteration limit
  /// Barrier parameter for a start at a guess, in units of the cost.
  double start_barrier = 0.03;
  /// Minimum slack-multiplier product of a warm start, in units of the cost. Large multipliers
  /// increase it.
  double warm_barrier = 1e-5;
  /// False: the Hessian may be indefinite, and the solver looks for a local solution.
  bool convex = true;
};

/// Result of a quadratic program solve.
struct QpResult {
  QpStatus status = QpStatus::invalid_problem;  ///< see is_success() and describe()
  int iterations = 0;      ///< predictor-corrector steps; a least-squares start adds one solve
  double objective = 0.0;  ///< cost at the point
  double residual = 0.0;   ///< KKT residual at the point, unscaled
  double violation = 0.0;  ///< largest violation of a hard row, bound or equality at the point
};

// Assignment of the variables and rows of a sparse program to stages. A transcription provides it,
// because it cannot be derived from the sparsity patterns.

/// Assignment of variables and rows of a sparse program to stages. Variables and rows are indices
/// into the sparse program. Each appears here exactly once.
///
/// A variable that shares a row or Hessian entry with a variable of a later stage is carried there
/// as an additional state while that entry is active. Rows and entries may thus join any stages;
/// only the width of the stages grows. Variables with equal bounds are eliminated.
struct StageStructure {
  /// Variables and rows of one stage.
  struct Stage {
    std::vector<int> states = {}, inputs = {};  ///< indices of variables of the program
    /// Equality rows that define the states of the next stage, in their order. Each row contains
    /// its own next state and no other variable of a later stage.
    std::vector<int> dynamics = {};
    /// Other rows, in groups with the same columns. They contain no variable of a later stage.
    std::vector<std::vector<int>> groups = {};
    /// Positions in `inputs`, each the first of `resultant_size` inputs that act on the next states
    /// through a common resultant (see saltus::Stage). Used if no other inputs exist.
    std::vector<int> resultants = {};
    int resultant_size = 0;  ///< as Stage::resultant_size of the program in stages
  };
  std::vector<Stage> stages;  ///< stages in order

  /// One row per state of the first stage, on that state alone: its value or its bounds.
  std::vector<int> start_rows;
  /// Variables that belong to no stage. They are carried from the first stage that uses them to the
  /// last.
  std::vector<int> globals;
  /// Sets of variables of different stages that share one additional state, because no two of them
  /// are carried into the same stage. A variable that is not listed here has its own state.
  std::vector<std::vector<int>> carried;

  /// Variables that only penalise the violation of a row: bounded below, in no other row, and
  /// without mixed Hessian entries. They are eliminated.
  struct SoftRow {
    int row = 0;                 ///< index of the row in the program
    int below = -1, above = -1;  ///< slacks of the lower and upper side; -1: none
  };
  std::vector<SoftRow> soft_rows;  ///< rows whose slacks are variables of the program
};

}  // namespace saltus::qp

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using QpStatus [[deprecated("use qp::QpStatus; removed in 0.4")]] = qp::QpStatus;
/// Deprecated name.
using QpOptions [[deprecated("use qp::QpOptions; removed in 0.4")]] = qp::QpOptions;
/// Deprecated name.
using QpResult [[deprecated("use qp::QpResult; removed in 0.4")]] = qp::QpResult;
/// Deprecated name.
using StageStructure [[deprecated("use qp::StageStructure; removed in 0.4")]] = qp::StageStructure;
/// Deprecated name.
using QpStart [[deprecated("use qp::QpOptions::Start; removed in 0.4")]] = qp::QpOptions::Start;
}  // namespace saltus
