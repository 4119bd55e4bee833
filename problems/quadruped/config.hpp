// Everything a run of the quadruped can be told, with its defaults.
#pragma once

#include <string>

#include "problems/quadruped/controller.hpp"
#include "saltus/app/settings.hpp"

namespace saltus::quadruped {

struct Config {
  ControllerSettings controller;
  PlantSettings plant;
  std::string gait = "trot";
  double duration = 20.0;   // s
  double roughness = 0.08;  // of the ground: nearly all of it is within so much of level, m
  double impulse = 16.0;    // of the push, N s
  double towards = 90.0;    // of the push, from straight ahead to the left, degrees
  double noise = 0.0;       // of what is measured, in multiples of what config.cpp says
  int seed = 1;
  int runs = 0;        // of a campaign; 0: one run
  double scale = 1.0;  // of roughness and push
  bool pictures = true;
};

/// Binds every key to its field, with units, ranges and rules.
void declare_settings(Settings& settings, Config& config);

/// The named gait's lifts and duty.
void apply_gait(const std::string& name, GaitSettings& gait);

}  // namespace saltus::quadruped
