// Random optimal control problems: nonlinear programs in stages that have a solution, or have none,
// by construction.
#pragma once

#include <string>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// One to three phases of 2 or 4 states and 1 or 2 inputs. Dynamics are linear with sines and
/// products of states and inputs; costs are squares about a reference that is not the start's, some
/// with cosines. Inputs and some states are bounded, rows keep the state out of discs or inside
/// curved regions, phases may have free durations (their sum given or charged) and are entered
/// through nonlinear jumps, and part of the last state is given. A trajectory of random inputs
/// satisfies all that strictly but for the equalities, which it satisfies to rounding.
struct RandomProgram {
  OptimalControlProblem problem;
  ShootingOptions options;
  std::string contradiction;  ///< the term that cannot be met; empty: there is a solution
};
RandomProgram random_program(unsigned seed);
/// The same with one more term that contradicts the others.
RandomProgram contradictory_program(unsigned seed);

}  // namespace saltus
