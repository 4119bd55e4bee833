// A trajectory as the verifier takes it.
#pragma once

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/trajectory.hpp"
#include "saltus/verify/plan.hpp"

namespace saltus {

/// The plan of a trajectory of this problem, without a cost. Allocates.
Plan plan_of(const OptimalControlProblem& problem, const Trajectory& trajectory);

}  // namespace saltus
