// The official model of iCub, URDF and meshes: where it lies on this machine, and how it gets
// there.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace saltus {

/// The URDF of iCubGazeboV2_5 that SALTUS_ICUB_URDF names, else the one fetched before into the
/// user's cache folder, else none.
std::optional<std::filesystem::path> find_icub_urdf();

/// The same; if there is none and SALTUS_ICUB_URDF is not set, fetches the model (the package
/// icub-models of PyPI, 18 MB, CC BY-SA 4.0; its hash is checked) into the cache folder. `say` gets
/// one line about it. Throws InputError with one sentence if it cannot be had.
std::filesystem::path fetch_icub_urdf(const std::function<void(const std::string&)>& say);

}  // namespace saltus
