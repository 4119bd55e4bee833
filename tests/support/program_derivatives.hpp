// Compares the derivatives of a program with central differences of its values, entry by entry,
// including entries that the pattern declares zero.
#pragma once

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus::testing_support {

struct DerivativeErrors {
  double gradient = 0.0, jacobian = 0.0, hessian = 0.0;  ///< largest error, relative to 1 + |entry|
};

/// A point near w inside the bounds, with multipliers. The seed determines it.
NlpPoint perturbed(const NonlinearProgram& program, const VectorXd& w, unsigned seed,
                   double radius = 0.05);

/// The steps are h. Variables are scaled, so 1e-5 leaves 1e-10 of truncation and 1e-11 of rounding.
DerivativeErrors derivative_errors(NonlinearProgram& program, const NlpPoint& point,
                                   Curvature curvature = Curvature::exact, double h = 1e-5);

}  // namespace saltus::testing_support
