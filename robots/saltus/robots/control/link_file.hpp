// The file with everything that is adjusted to a real robot: joints, gains, filters and guards.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "saltus/robots/control/robot_control.hpp"

namespace saltus::robots::control {

/// Reads the file (docs/first_hour.md) into the joints and options, which keep what it does not
/// mention. If `joints` is empty, the file must list all of them; otherwise it may adjust some.
/// Throws InputError with file and key.
void read_link_file(const std::filesystem::path& file, std::vector<LinkJoint>& joints,
                    ControlOptions& options);

/// Writes these joints and options as such a file, with comments.
std::string to_link_file(const std::vector<LinkJoint>& joints, const ControlOptions& options);

}  // namespace saltus::robots::control
