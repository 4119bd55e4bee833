// How large the states of a plan are, which errors are relative to where nobody declared a nominal
// magnitude: states of 1e-6 that are off by half are not right to 1e-6.
#pragma once

#include <vector>

#include "saltus/transcription/trajectory.hpp"

namespace saltus {

/// What errors of the states of each phase are relative to where the states are not larger: the
/// nominal magnitudes or, where none is declared, the largest at the nodes of the plan (of all
/// phases with as many states) if that is below 1. What stays below 1e-9 counts as 1e-9. Allocates.
std::vector<VectorXd> units_of_states(const Trajectory& trajectory);

}  // namespace saltus
