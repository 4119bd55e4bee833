// The robot file: joints, gains, filters and guards that are adjusted to a real robot.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "saltus/robots/control/robot_control.hpp"

namespace saltus::robots::control {

/// Reads a robot file (docs/robot_link.md) into the joints and options. Values that the file does
/// not contain are kept. If `joints` is empty, the file must list all joints; otherwise it may
/// adjust some. Throws InputError that names file and key.
void read_link_file(const std::filesystem::path& file, std::vector<LinkJoint>& joints,
                    ControlOptions& options);

/// Text of a robot file with these joints and options, and with comments.
std::string to_link_file(const std::vector<LinkJoint>& joints, const ControlOptions& options);

}  // namespace saltus::robots::control
