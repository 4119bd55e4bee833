// The driver of a robot, here a stub of a robot that stands still. Replace it by yours.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/types.hpp"

struct Driver {
  double clock = 5000.0;                                       // s
  std::vector<std::string> joints;                             // names in the URDF, in any order
  std::vector<double> positions, torques;                      // rad and Nm, in that order
  saltus::Vec<double, 3> gyroscope = {0.0, 0.0, 0.0};          // rad/s, axes of the root link
  saltus::Vec<double, 3> accelerometer = {0.0, 0.0, 9.80665};  // m/s^2, at its origin, in its axes
  // (N | Nm) of the ground on the left and the right sole, in their axes.
  saltus::Vec<double, 12> soles = saltus::Vec<double, 12>::Zero();

  // Waits for the next sample. Returns false if there is none.
  bool next_sample() {
    clock += 0.001;
    return true;
  }
};
