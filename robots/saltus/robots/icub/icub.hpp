// Description of the iCub humanoid, from the official URDF or from the built-in parameter file.
#pragma once

#include <filesystem>
#include <optional>

#include "saltus/robots/model/robot_description.hpp"

namespace saltus {

/// Description of iCubGazeboV2_5. With a URDF (the package icub-models has the official one) the
/// data are computed from it. Otherwise they are those of robots/icub/icub.yaml, which is built in.
/// `RobotDescription::source` names the origin. Throws InputError like `UrdfModel::read`.
RobotDescription icub(const std::optional<std::filesystem::path>& urdf = std::nullopt);

}  // namespace saltus
