// Proves by multipliers of the affine rows that no point satisfies the rows and bounds of a
// program.
#pragma once

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// True if multipliers show that the affine rows and the bounds contradict each other (Farkas), so
/// that no point satisfies them. Coefficients count as known to rounding error. `w` is any point
/// where the program can be evaluated. False proves nothing. Solves one quadratic program and
/// allocates.
bool is_proved_infeasible(NonlinearProgram& program, const VectorXd& w);

}  // namespace saltus
