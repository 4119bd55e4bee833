// What a shooting solves next, as a problem of its own.
#pragma once

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// The problem with the present data of the shooting, as a controller has it: start, times,
/// schedule, parameters. Independent of the shooting. Allocates: outside of ticks.
OptimalControlProblem present_problem(const MultipleShooting& shooting);

}  // namespace saltus
