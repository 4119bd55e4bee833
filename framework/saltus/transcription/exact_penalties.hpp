// Solves a program whose L1 penalty weights far exceed the multipliers of their rows.
//
// An L1 penalty is exact if its weight exceeds the multiplier: the solution is then the same for
// every larger weight. Large weights are therefore lowered first. If a lowered penalty is violated,
// its weight is raised again, up to the value in the problem.
#pragma once

#include "saltus/solver/solve_in_scale.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// Presolves the program and solves it with solve_in_scale(), or with solve_as_stated() if
/// `in_scale` is false. The result refers to the weights of the problem. The program is unchanged
/// afterwards.
ScaledResult solve_with_penalties(Solver& solver, ShootingProgram& program, const NlpPoint& start,
                                  bool warm, bool in_scale);

}  // namespace saltus
