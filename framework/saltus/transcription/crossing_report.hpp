// Checks whether the guards that end phases cross zero there as declared. A solver enforces guard =
// 0 only. The guard may cross in the wrong direction, the trajectory may graze the surface, or an
// earlier crossing may exist.
#pragma once

#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

/// One entry per phase that ends with a guard, in order. Samples the guard before the end at the
/// nodes of the trajectory. `samples` adds points inside each interval, from dense output.
std::vector<Solution::GuardCrossing> guard_crossings(const OptimalControlProblem& problem,
                                                     const Trajectory& trajectory, int samples = 0);

/// One clause for a crossing that differs from its declaration. Empty if it is as declared.
std::string describe_crossing_error(const Solution::GuardCrossing& crossing);

}  // namespace saltus
