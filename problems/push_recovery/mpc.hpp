// The receding horizon controller of the paper.
#pragma once

#include <memory>

#include "problems/push_recovery/config.hpp"

namespace saltus::push_recovery {

/// Creates the controller for a robot of this mass in the stance of the scene.
std::unique_ptr<Planner> make_mpc(const Config& config, const robots::RobotDescription& robot,
                                  const Scene& scene);

}  // namespace saltus::push_recovery
