// Converts a trajectory into a plan for the verifier.
#pragma once

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/trajectory.hpp"
#include "saltus/verify/plan.hpp"

namespace saltus {

/// The plan of a trajectory of this problem, without cost. Allocates.
Plan plan_of(const OptimalControlProblem& problem, const Trajectory& trajectory);

}  // namespace saltus
