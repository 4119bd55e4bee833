// The units of variables whose magnitudes nobody declared, from what a program tells of them.
#pragma once

#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// What each variable is to be multiplied by (ProgramScale::variables): the same for all variables
/// of a quantity, 1 for variables of none and where the size is usual. The size of a quantity is
/// the largest of its values at w; where they are zero, it is estimated: what moves a row as far as
/// quantities of known size do, within its bounds, or else the size of its bounds. Estimates count
/// where they are very large or very small only.
VectorXd measure_variables(NonlinearProgram& program, const VectorXd& w,
                           const std::vector<std::vector<int>>& quantities);

}  // namespace saltus
