// Are the derivatives of a program those of its values? Against central differences, entry by
// entry, also where the pattern says zero.
#pragma once

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus::testing_support {

struct DerivativeErrors {
  double gradient = 0.0, jacobian = 0.0, hessian = 0.0;  ///< largest, relative to 1 + |entry|
};

/// A point near w, inside the bounds, and multipliers: reproducible from the seed.
NlpPoint perturbed(const NonlinearProgram& program, const VectorXd& w, unsigned seed,
                   double radius = 0.05);

/// Steps h: variables are scaled, so that 1e-5 leaves 1e-10 of truncation and 1e-11 of rounding.
DerivativeErrors derivative_errors(NonlinearProgram& program, const NlpPoint& point,
                                   Curvature curvature = Curvature::exact, double h = 1e-5);

}  // namespace saltus::testing_support
