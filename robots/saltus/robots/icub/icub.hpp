// Description of the iCub humanoid, from the official URDF or from the built-in parameter file, and
// the location and download of its official model (URDF and meshes).
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "saltus/robots/model/robot_description.hpp"

namespace saltus::robots {

/// Description of iCubGazeboV2_5. With a URDF (the package icub-models has the official one) the
/// data are computed from it. Otherwise they are those of robots/icub/icub.yaml, which is built in.
/// `RobotDescription::source` names the origin. Throws InputError like `UrdfModel::read`.
RobotDescription icub(const std::optional<std::filesystem::path>& urdf = std::nullopt);

/// The URDF of iCubGazeboV2_5 named by SALTUS_ICUB_URDF, else the one downloaded before into the
/// user's cache folder, else none.
std::optional<std::filesystem::path> find_icub_urdf();

/// Like find_icub_urdf(). If there is none and SALTUS_ICUB_URDF is not set, downloads the model
/// (the package icub-models of PyPI, 18 MB, CC BY-SA 4.0, with a check of its hash) into the cache
/// folder. `say` receives one line about the download. Throws InputError, one sentence, on failure.
std::filesystem::path fetch_icub_urdf(const std::function<void(const std::string&)>& say);

}  // namespace saltus::robots

namespace saltus {              // deprecated names, removed in 0.4
using robots::fetch_icub_urdf;  ///< deprecated name
using robots::find_icub_urdf;   ///< deprecated name
using robots::icub;             ///< deprecated name
}  // namespace saltus
