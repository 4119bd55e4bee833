// The robot of the settings: from its URDF, from a description file, or the built-in data of iCub.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus::robots::walking {

/// The chosen robot: from its URDF if there is one, else from its file. With `needs_urdf` (whole
/// body), a missing URDF is an error. Throws InputError for missing or wrong entries of the files.
RobotDescription robot_of(const RobotChoice& choice, bool needs_urdf = false);

/// The URDF of the settings. If there is none, the official model of iCub, provided that the set-up
/// fetched it and no other robot is chosen. Otherwise nothing: the data come from the robot's file.
std::optional<std::filesystem::path> urdf_of(const RobotChoice& choice);

/// Like urdf_of(), for the whole body. Throws InputError without a URDF.
std::filesystem::path urdf_of_body(const RobotChoice& choice);

/// The controllers' model of the robot, with the mass error of the settings.
RobotDescription nominal_robot(const RobotChoice& choice, RobotDescription robot);

}  // namespace saltus::robots::walking
