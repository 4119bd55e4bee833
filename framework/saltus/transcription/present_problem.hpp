// The next solve of a shooting as a separate problem.
#pragma once

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// The problem with the current data of the shooting, e.g. in a controller: start, times, schedule,
/// parameters. Independent of the shooting. Allocates, so do not call it in a control loop.
OptimalControlProblem present_problem(const MultipleShooting& shooting);

}  // namespace saltus
