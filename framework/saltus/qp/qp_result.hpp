// Options and results of all solvers of quadratic programs.
#pragma once

#include "saltus/core/clock.hpp"

namespace saltus {

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

/// Starting point of a cold start.
enum class QpStart {
  least_squares,  ///< needs no guess; costs about as much as one iteration
  guess,          ///< at the given point, whose active set should be close to the optimal one
};

/// Options of a quadratic program solver.
struct QpOptions {
  QpStart start = QpStart::least_squares;  ///< start of the iteration
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

}  // namespace saltus
