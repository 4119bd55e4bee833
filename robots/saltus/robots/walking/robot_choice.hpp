// Which robot: from its URDF, from a file of figures, or iCub's that come with the program.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "saltus/robots/model/robot_description.hpp"

namespace saltus::walking {

/// Which robot, from which files.
struct RobotChoice {
  std::string urdf;  ///< empty: the figures of robots/icub, or those of `file`
  std::string file;  ///< names, postures and limits; empty: iCub's
  /// Relative error of all masses and inertias in the controllers' model; the plant has none.
  double mass_error = 0.0;
};

/// The robot that is asked for: of its URDF if there is one, else as its file says. With
/// `needs_urdf` (a whole body) the lack of one is an error. Throws InputError for what the files
/// lack or say wrongly.
RobotDescription robot_of(const RobotChoice& choice, bool needs_urdf = false);

/// The setting, else the official model of iCub if the set-up fetched it and no other robot is
/// asked for, else none: the figures are those of the robot's file.
std::optional<std::filesystem::path> urdf_of(const RobotChoice& choice);

/// The same for the whole body, which needs the URDF itself. Throws InputError without one.
std::filesystem::path urdf_of_body(const RobotChoice& choice);

/// The robot as its controllers know it: its mass with the error.
RobotDescription nominal_robot(const RobotChoice& choice, RobotDescription robot);

}  // namespace saltus::walking
