// The iCub humanoid: its figures, from the official URDF or from the parameter file built in.
#pragma once

#include <filesystem>
#include <optional>

#include "saltus/robots/model/robot_description.hpp"

namespace saltus {

/// The figures of iCubGazeboV2_5. With a URDF (the package icub-models has the official one) they
/// are computed from it; otherwise they are those of robots/icub/icub.yaml, which the program
/// carries. `RobotDescription::source` says which. Throws InputError as `UrdfModel::read` does.
RobotDescription icub(const std::optional<std::filesystem::path>& urdf = std::nullopt);

}  // namespace saltus
