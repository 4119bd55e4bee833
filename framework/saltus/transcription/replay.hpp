// Integrates the inputs of a solution again with another, tighter integrator, to check the plan.
#pragma once

#include "saltus/model/integrator.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/solution.hpp"
#include "saltus/verify/verify.hpp"

namespace saltus {

/// Differences between plan and replay, |difference| / max(nominal, |state|), largest entry.
/// Without a declared nominal magnitude, the largest value along the plan replaces it if that is
/// below 1.
struct ReplayReport {
  bool completed = false;    ///< true if no integration failed
  double from_nodes = 0.0;   ///< every interval from its planned start
  double from_start = 0.0;   ///< the whole plan from its start, including jumps
  double flow_growth = 1.0;  ///< largest singular value of d state / d start along the plan
};

/// Integrates the inputs of the trajectory with `integrator`, per interval and from the start.
/// Throws DefinitionError if the trajectory is empty or its phases do not match the problem.
ReplayReport replay(const OptimalControlProblem& problem, const Trajectory& trajectory,
                    const IntegratorChoice& integrator);

// Converts a trajectory into a plan for the verifier.

/// The plan of a trajectory of this problem, without cost. Allocates.
Plan plan_of(const OptimalControlProblem& problem, const Trajectory& trajectory);

}  // namespace saltus
