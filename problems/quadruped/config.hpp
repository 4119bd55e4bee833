// All settings of a run of the quadruped, with defaults.
#pragma once

#include <string>

#include "problems/quadruped/controller.hpp"
#include "saltus/app/settings.hpp"

namespace saltus::quadruped {

struct Config {
  ControllerSettings controller;
  PlantSettings plant;
  std::string gait = "trot";
  double duration = 20.0;          // s
  double roughness = 0.08;         // maximum ground height almost everywhere, m
  Pulse push{16.0, {}, 1.0, 0.1};  // on the CoM, N s; its direction is `towards`
  double towards = 90.0;           // direction of the push, degrees; 0 forward, 90 left
  double noise = 0.0;  // noise of the measurements, as a multiple of the values in run.cpp
  int seed = 1;
  int runs = 0;        // runs of a campaign; 0: one run
  double scale = 1.0;  // factor on roughness and push
  bool pictures = true;
};

/// Binds every key to its field, with units, ranges and rules.
void declare_settings(Settings& settings, Config& config);

/// Lift-off times and duty factor of a gait by name.
void apply_gait(const std::string& name, GaitSettings& gait);

}  // namespace saltus::quadruped
