// What `run push_recovery` and `map` share: where the robot's file lies, and the picture scripts.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "problems/push_recovery/config.hpp"
#include "saltus/robots/model/robot_description.hpp"

namespace saltus::push_recovery {

/// The robot of the settings: of its URDF if there is one, else as its file says. Throws InputError
/// for what the files lack or say wrongly.
RobotDescription robot_of(const Config& config);

/// The setting, else the official model of iCub if the set-up fetched it and no other robot is
/// asked for, else none: the figures are those of the robot's file.
std::optional<std::filesystem::path> urdf_of(const Config& config);

/// The same for the whole body, which needs the URDF itself. Throws InputError without one.
std::filesystem::path urdf_of_body(const Config& config);

/// Runs a python script of this folder on a folder of results, without a shell. Pictures are a
/// service: the absence of `what` is said on the error stream, not fatal.
void draw(const std::filesystem::path& results, const char* what, const std::string& script);

/// The files that a run left in its folder and how to open them, one line each. Files that were
/// there before `begin` are of another run and not listed.
std::string results_text(const std::filesystem::path& results,
                         std::filesystem::file_time_type begin);

}  // namespace saltus::push_recovery
