// Is the plan true? The inputs of a solution integrated again with another, tighter integrator.
#pragma once

#include "saltus/model/integrator.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/trajectory.hpp"

namespace saltus {

/// Differences between plan and replay, |difference| / max(nominal, |state|), largest entry; where
/// no nominal magnitude is declared, the largest along the plan stands for it if that is below 1.
struct ReplayReport {
  bool completed = false;    ///< no integration failed
  double from_nodes = 0.0;   ///< every interval from its own planned start
  double from_start = 0.0;   ///< the whole plan from the start, jumps included
  double flow_growth = 1.0;  ///< largest singular value of d state / d start along the plan
};

/// Integrates the inputs of the trajectory with `integrator`, per interval and from the start.
/// Throws DefinitionError where the trajectory is empty or has other phases than the problem.
ReplayReport replay(const OptimalControlProblem& problem, const Trajectory& trajectory,
                    const IntegratorChoice& integrator);

}  // namespace saltus
