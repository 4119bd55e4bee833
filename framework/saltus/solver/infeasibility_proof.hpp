// Proves that no point meets the rows and bounds of a program, by multipliers of its affine rows.
#pragma once

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// True if multipliers were found with which the affine rows and the bounds contradict one another
/// (Farkas), so that no point at all meets them. Coefficients count as known to rounding. `w` is
/// any point where the program can be evaluated. False proves nothing. Solves one quadratic program
/// and allocates.
bool is_proved_infeasible(NonlinearProgram& program, const VectorXd& w);

}  // namespace saltus
