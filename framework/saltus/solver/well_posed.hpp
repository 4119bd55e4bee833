// Tests whether a program and a start are valid input of a solver.
#pragma once

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// True if the start has an entry per variable, and every variable and row has a finite value
/// within its bounds (no NaN).
bool is_well_posed(const NonlinearProgram& program, const NlpPoint& start);

}  // namespace saltus
