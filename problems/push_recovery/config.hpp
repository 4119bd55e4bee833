// Everything a run of push recovery can be told, with its defaults: what any biped in a closed loop
// can be told, and the weights of the cost.
#pragma once

#include "problems/push_recovery/problem.hpp"
#include "problems/push_recovery/step_settings.hpp"
#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus::push_recovery {

using namespace walking;

struct Config : BipedSettings {
  Config() { preset = "paper"; }
  Weights weights;
  StepPlanning planning;
  /// Of a map over step times: preset `robot` leaves the planner that takes them.
  bool step_times_are_given = false;
};

/// Binds every key to its field, with units, ranges and rules.
void declare_settings(Settings& settings, Config& config);

}  // namespace saltus::push_recovery
