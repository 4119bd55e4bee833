// The closed loop on the whole body: planner at its period, whole-body controller above it, plant.
#pragma once

#include "saltus/robots/walking/simulation.hpp"

namespace saltus::push_recovery {

RunLog simulate_full_body(const Config& config, const RobotDescription& robot,
                          const std::filesystem::path& urdf, const Observer& observer = {});

}  // namespace saltus::push_recovery
