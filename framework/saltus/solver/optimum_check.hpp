// Checks whether a point is an optimum of the program as stated: how much its cost could still
// decrease, to first and second order, in the units of the cost.
//
// The check uses the KKT matrix [H + Z/G, A'; A, -G/L] of the primal-dual equations. G are the
// distances to the sides, Z and L the multipliers of bounds and inequality rows (Nocedal and
// Wright, Numerical Optimization, 2nd ed., sec. 19.3). A side counts by its multiplier over its
// distance. The result is therefore independent of units, and small multipliers of a barrier method
// count correctly.
#pragma once

#include "saltus/core/bounds.hpp"
#include "saltus/solver/nonlinear_program.hpp"
#include "saltus/solver/program_scale.hpp"

namespace saltus {

/// Result of a first- and second-order optimality check.
struct OptimumCheck {
  /// Second-order classification of the point.
  enum class Curvature {
    minimum,       ///< the cost rises along every feasible direction
    inconclusive,  ///< second derivatives vanish along some direction; higher ones decide
    descent,       ///< the cost decreases along `direction` and along its negative
    unknown        ///< no second derivatives, or the matrix could not be judged
  };
  Curvature curvature = Curvature::unknown;  ///< second-order result
  VectorXd direction;    ///< direction of least curvature, largest entry 1; may be empty
  int variable = -1;     ///< variable with the largest entry of the direction
  double descent = 0.0;  ///< predicted decrease of the cost along it, within all sides; not
                         ///< negative

  /// Sum of |multiplier| x distance to its side: bound on the suboptimality in a convex program.
  /// Infinite if the point could not be evaluated.
  double gap = infinity;
  /// Predicted decrease of the cost by a Newton step from the residual of stationarity.
  double gain = 0.0;
  /// Reference for gap and gain: |cost| or, if larger, the change of the cost when a variable moves
  /// by its size, at most 1.
  double magnitude = 1.0;

  /// Possible decrease of the cost by the first-order conditions, relative to its size.
  double relative_gain() const { return (gap + gain) / magnitude; }
};

/// Checks a point with its multipliers. `quantities` group variables of one size. Allocates and
/// factors one matrix of the size of the program; for analysis, not for control loops.
OptimumCheck check_optimum(NonlinearProgram& program, const NlpPoint& point,
                           const Quantities& quantities = {});

}  // namespace saltus
