// Choice of the robot: from its URDF, from a description file, or the built-in data of iCub.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "saltus/robots/model/robot_description.hpp"

namespace saltus::walking {

/// Files of the robot.
struct RobotChoice {
  std::string urdf;  ///< empty: the data of robots/icub, or those of `file`
  std::string file;  ///< names, postures and limits; empty: those of iCub
  /// Relative error of all masses and inertias in the controllers' model. The simulated robot is
  /// exact.
  double mass_error = 0.0;
};

/// The chosen robot: from its URDF if there is one, else from its file. With `needs_urdf` (whole
/// body), a missing URDF is an error. Throws InputError for missing or wrong entries of the files.
RobotDescription robot_of(const RobotChoice& choice, bool needs_urdf = false);

/// The URDF of the settings. Without it, the official model of iCub, if the set-up fetched it and
/// no other robot is chosen. Otherwise none: the data come from the robot's file.
std::optional<std::filesystem::path> urdf_of(const RobotChoice& choice);

/// Like urdf_of(), for the whole body. Throws InputError without a URDF.
std::filesystem::path urdf_of_body(const RobotChoice& choice);

/// The robot as its controllers know it, with the error of the mass.
RobotDescription nominal_robot(const RobotChoice& choice, RobotDescription robot);

}  // namespace saltus::walking
