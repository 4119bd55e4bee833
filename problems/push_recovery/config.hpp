// Settings of push recovery with their defaults: those of any biped in a closed loop, and the
// weights of the cost.
#pragma once

#include "problems/push_recovery/problem.hpp"
#include "problems/push_recovery/step_settings.hpp"
#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus::push_recovery {

using namespace walking;

struct Config : BipedSettings {
  Config() { preset = "paper"; }
  std::string drives = "ideal";  ///< preset of the drives
  Weights weights;
  /// Desired angular momentum while the capture point would come to rest off the support, as a
  /// multiple of the one that stops it there.
  double capturing_momentum = 0.0;
  StepPlanning planning;
  /// True in a map over step times: preset `robot` then keeps a planner that accepts them.
  bool step_times_are_given = false;
};

/// Declares every key with its field, unit, range and rules.
void declare_settings(Settings& settings, Config& config);

}  // namespace saltus::push_recovery
