// Did the guards that end phases really cross zero there? A solver only knows guard = 0: it may
// end a phase where the guard passes the wrong way, where the trajectory grazes the surface, or
// after it had already been crossed.
#pragma once

#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

/// One entry for every phase that ends by a guard, in order. The guard before the end is looked at
/// at the nodes of the trajectory and at so many points inside each interval, along the dense
/// output.
std::vector<GuardCrossing> guard_crossings(const OptimalControlProblem& problem,
                                           const Trajectory& trajectory, int samples = 0);

/// One clause for a crossing that is not what was declared, or an empty string.
std::string describe_doubtful(const GuardCrossing& crossing);

}  // namespace saltus
