// A run of push recovery within a test.
#pragma once

#include "problems/push_recovery/criteria.hpp"
#include "problems/push_recovery/mpc.hpp"
#include "problems/push_recovery/push_recovery.hpp"

namespace saltus::push_recovery {

inline RunLog simulate(const Config& config, const robots::RobotDescription& robot) {
  return walking::simulate(PushRecovery(config), robot);
}

}  // namespace saltus::push_recovery
