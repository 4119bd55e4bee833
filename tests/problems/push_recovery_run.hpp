// A run of push recovery within a test.
#pragma once

#include <string>
#include <vector>

#include "problems/push_recovery/criteria.hpp"
#include "problems/push_recovery/mpc.hpp"
#include "problems/push_recovery/push_recovery.hpp"
#include "saltus/app/settings.hpp"

namespace saltus::push_recovery {

inline RunLog simulate(const Config& config, const robots::RobotDescription& robot) {
  return walking::simulate(PushRecovery(config), robot);
}

// Applies arguments as after `saltus run push_recovery --set`.
inline void apply(const std::vector<std::string>& arguments, Config& config) {
  Settings settings;
  declare_settings(settings, config);
  std::vector<Assignment> given;
  given.reserve(arguments.size());
  for (const std::string& argument : arguments) given.push_back(parse_set_argument(argument));
  settings.apply(given);
}

inline Config config_of(const std::vector<std::string>& arguments) {
  Config config;
  apply(arguments, config);
  return config;
}

}  // namespace saltus::push_recovery
