// The official model of iCub (URDF and meshes): its location on this machine and its download.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace saltus {

/// The URDF of iCubGazeboV2_5 that SALTUS_ICUB_URDF names, else the one downloaded before into the
/// user's cache folder, else none.
std::optional<std::filesystem::path> find_icub_urdf();

/// Like find_icub_urdf(). If there is none and SALTUS_ICUB_URDF is not set, downloads the model
/// (the package icub-models of PyPI, 18 MB, CC BY-SA 4.0, with a check of its hash) into the cache
/// folder. `say` gets one line about it. Throws InputError, one sentence, on failure.
std::filesystem::path fetch_icub_urdf(const std::function<void(const std::string&)>& say);

}  // namespace saltus
