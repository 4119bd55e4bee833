// What every solver of quadratic programs takes and says.
#pragma once

#include "saltus/core/clock.hpp"

namespace saltus {

/// Why a solve ended. A solve that does not converge is a result, never an exception.
enum class QpStatus {
  optimal,
  infeasible,  ///< a certificate was found: no point satisfies the rows and bounds
  unbounded,   ///< a certificate was found: the cost falls without limit along a direction
  iteration_limit,
  deadline,  ///< wall clock; the point is the last iterate
  numerical_failure,
  invalid_problem,  ///< NaN in the data, or bounds that no number satisfies
};
/// One sentence.
const char* describe(QpStatus status);

/// Where a cold start begins.
enum class QpStart {
  least_squares,  ///< needs no guess and costs about as much as an iteration
  guess,          ///< at the given point, which should be near the optimum in what binds
};

/// How a quadratic program is solved.
struct QpOptions {
  QpStart start = QpStart::least_squares;  ///< where the iteration begins
  double tolerance = 1e-8;   ///< largest KKT residual: stationarity, feasibility, complementarity
  int max_iterations = 100;  ///< after which it gives up
  /// Barrier parameter of a start at a guess, in units of the cost.
  double start_barrier = 0.03;
  /// Slacks and multipliers of a warm start have products of at least this, in units of the cost;
  /// more where multipliers are large.
  double warm_barrier = 1e-5;
  /// False: the Hessian may be indefinite, and a local solution is what is asked for.
  bool convex = true;
};

/// What a solve of a quadratic program gave.
struct QpResult {
  QpStatus status = QpStatus::invalid_problem;  ///< as is_success() and describe() read it
  int iterations = 0;      ///< predictor-corrector steps; a least-squares start adds one solve
  double objective = 0.0;  ///< cost at the point
  double residual = 0.0;   ///< KKT residual at the point, unscaled
  double violation = 0.0;  ///< largest violation of a hard row, bound or equality at the point
};

}  // namespace saltus
