// Solving a program whose L1 penalties have weights far above the multipliers of their rows.
//
// An L1 penalty is exact as soon as its weight exceeds the multiplier: the solution is that of any
// larger weight. So large weights are lowered first. Where a lowered penalty gives way they are
// raised again, up to what the problem asks for.
#pragma once

#include "saltus/solver/solve_in_scale.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// solve_in_scale() of what presolve() leaves of the program, or solve_as_stated() where `in_scale`
/// is false, with the weights of the problem in the result. Leaves the program as it was.
ScaledResult solve_with_penalties(Solver& solver, ShootingProgram& program, const NlpPoint& start,
                                  bool warm, bool in_scale);

}  // namespace saltus
