// The receding horizon controller of the paper: the problem's data from measurement and scene.
#pragma once

#include <memory>

#include "problems/push_recovery/config.hpp"

namespace saltus::push_recovery {

/// For a robot of this mass that stands as the scene says.
std::unique_ptr<Planner> make_mpc(const Config& config, const RobotDescription& robot,
                                  const Scene& scene);

}  // namespace saltus::push_recovery
