// Is a point an optimum? Judged from the program as it is stated: how much its cost could still
// fall, to first and to second order, in the units of the cost.
//
// The KKT matrix [H + Z/G, A'; A, -G/L] of the primal-dual equations decides, with G the distances
// to the sides and Z, L the multipliers of bounds and inequality rows (Nocedal and Wright,
// Numerical Optimization, 2nd ed., sec. 19.3). A side counts by its multiplier over its distance,
// so that units do not matter and a barrier method's small multipliers hold what they hold.
#pragma once

#include "saltus/core/bounds.hpp"
#include "saltus/solver/nonlinear_program.hpp"
#include "saltus/solver/program_scale.hpp"

namespace saltus {

/// What first and second derivatives say of a point.
struct OptimumCheck {
  /// What second derivatives say.
  enum class Curvature {
    minimum,       ///< the cost rises along every direction that the constraints allow
    inconclusive,  ///< along some direction second derivatives vanish, and higher ones decide
    descent,       ///< along `direction`, and along its negative, the cost falls
    unknown        ///< there are no second derivatives, or the matrix could not be judged
  };
  Curvature curvature = Curvature::unknown;  ///< to second order
  VectorXd direction;                        ///< least curved, largest entry 1; may be empty
  int variable = -1;                         ///< the variable that moves most along it
  double descent = 0.0;  ///< predicted fall of the cost along it, within all sides; not negative

  /// Sum of |multiplier| x distance to its side: by how much the cost may exceed the optimal one
  /// in a convex program. Infinite where the point could not be evaluated.
  double gap = infinity;
  /// Predicted fall of the cost by a Newton step from the residual of stationarity.
  double gain = 0.0;
  /// What the two are compared with: |cost| or, where that is larger, the change of the cost when a
  /// variable moves by its size, at most 1.
  double magnitude = 1.0;

  /// How much the cost could still fall by the first-order conditions, relative to its size.
  double relative_gain() const { return (gap + gain) / magnitude; }
};

/// Judges a point with its multipliers. `quantities` tell which variables have one size. Allocates
/// and factors one matrix of the program's size; meant for analysis, not for control loops.
OptimumCheck check_optimum(NonlinearProgram& program, const NlpPoint& point,
                           const Quantities& quantities = {});

}  // namespace saltus
