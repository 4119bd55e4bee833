// Is a point that meets the first-order conditions a minimum? They hold at saddles and maxima too.
#pragma once

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// What the second derivatives say of a point.
struct SecondOrderCheck {
  /// What second-order conditions say.
  enum class Verdict {
    no_descent,  ///< along no direction that all constraints in force allow does the cost fall
    descent,     ///< along `direction`, and along its negative, the Lagrangian falls
    unknown      ///< there are no second derivatives, or the matrix could not be judged
  };
  Verdict verdict = Verdict::unknown;  ///< what they say
  VectorXd direction;                  ///< of descent, in variables of the program; largest entry 1
  double curvature = 0.0;              ///< d' H d along it
  int variable = -1;                   ///< the one that moves most
};

/// Constraints in force are equalities and all sides that the point meets, with or without a
/// multiplier: what is called descent lies in the null space of their Jacobian, so that where it is
/// found the point is no minimum. Curvature within rounding of zero counts as none: singular arcs
/// and flat optima pass. Judged by the inertia of the scaled KKT matrix (Nocedal and Wright,
/// Numerical Optimization, 2nd ed., theorem 16.3), and descent is confirmed by a vector. Allocates;
/// meant for analysis, not for control loops.
SecondOrderCheck check_second_order(NonlinearProgram& program, const NlpPoint& point);

}  // namespace saltus
