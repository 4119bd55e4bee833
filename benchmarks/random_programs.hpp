// Random optimal control problems: nonlinear programs in stages that are feasible or infeasible by
// construction.
#pragma once

#include <string>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// One to three phases of 2 or 4 states and 1 or 2 inputs. Dynamics are linear with sines and
/// products of states and inputs; costs are squares about a reference other than the start, some
/// with cosines. Inputs and some states are bounded. Rows keep the state outside discs or inside
/// curved regions. Phases may have free durations, whose sum is given or penalised, and begin with
/// nonlinear jumps; a part of the last state is given. A trajectory of random inputs satisfies all
/// inequalities strictly and all equalities to rounding.
struct RandomProgram {
  OptimalControlProblem problem;
  ShootingOptions options;
  std::string contradiction;  ///< the infeasible term; empty: the problem is feasible
};
RandomProgram random_program(unsigned seed);
/// A problem of the same kind with one more term that contradicts the others.
RandomProgram contradictory_program(unsigned seed);

}  // namespace saltus
