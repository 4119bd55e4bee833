// One closed loop over any plant and any planner of a biped.
#pragma once

#include "saltus/robots/walking/biped_problem.hpp"
#include "saltus/robots/walking/legged_plant.hpp"
#include "saltus/robots/walking/progress.hpp"

namespace saltus::walking {

/// Runs the problem on the plant that its settings name. Throws InputError for what the robot's
/// files lack or say wrongly.
RunLog simulate(const BipedProblem& problem, const RobotDescription& robot,
                const Observer& observer = {});

/// The same on a plant of the caller's.
RunLog simulate(const BipedProblem& problem, const RobotDescription& robot, LeggedPlant& plant,
                const Observer& observer = {});

}  // namespace saltus::walking
