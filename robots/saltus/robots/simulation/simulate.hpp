// Closed loops of a biped in simulation.
#pragma once

#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::robots::walking {

/// Runs the problem on the plant of its settings. Throws InputError for robot files that are
/// incomplete or inconsistent.
RunLog simulate(const BipedProblem& problem, const RobotDescription& robot,
                const Observer& observer = {});

/// Frame of `push.link`. Throws InputError that names this setting.
FloatingRobot::Frame pushed_frame(const FloatingRobot& robot, const UrdfModel& model,
                                  const std::string& link);

}  // namespace saltus::robots::walking
