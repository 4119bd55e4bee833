// Limits of the hardware that a run exceeds.
#pragma once

#include <string>
#include <vector>

#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::robots::walking {

/// All limits that a whole-body run exceeds, by time. Checks every sample without a filter: forces
/// and torques on the feet against the range of their sensors, speeds and positions of the joints,
/// torques of the motors against the torque-speed line, and distances of limbs. Limits come from
/// `RunLog::robot` and `RunLog::floating`.
std::vector<HardwareExcess> hardware_excesses(const RunLog& log);

/// One sentence about an excess, without a full stop.
std::string describe(const HardwareExcess& excess);

/// Largest downward speed with which a sole touches the ground, m/s; 0 if none does.
double landing_speed(const RunLog& log);

}  // namespace saltus::robots::walking
