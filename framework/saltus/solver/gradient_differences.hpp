// Computes the Hessian of the Lagrangian by differences of its gradient, for programs with first
// derivatives only.
#pragma once

#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Fills the entries of the Hessian of f + lambda' g in the order of `pattern` (lower triangle).
/// The Hessian must be zero outside the pattern. Central differences have the error (step)^2 = 1e-8
/// plus 1e4 times the noise of the first derivatives. Variables that share no row of the Hessian
/// are perturbed together (A. R. Curtis, M. J. D. Powell, J. K. Reid, 1974). Returns false if an
/// evaluation fails.
bool difference_gradients(NonlinearProgram& program, const NlpPoint& point,
                          const SparsityPattern& pattern, std::vector<double>& hessian);

}  // namespace saltus
