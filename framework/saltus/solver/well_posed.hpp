// Is this a program and a start that a solver can be given at all?
#pragma once

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Whether the start has an entry per variable, and every variable and row a finite value within
/// its bounds (so no NaN among them).
bool is_well_posed(const NonlinearProgram& program, const NlpPoint& start);

}  // namespace saltus
