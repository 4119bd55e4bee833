// Locations of files that a program reads at run time: plot scripts, recorded data, cached
// downloads.
#pragma once

#include <filesystem>
#include <string>

namespace saltus {

/// Path of the file or folder that the source tree calls `name`, e.g.
/// "robots/icub/fetch_icub_model". If SALTUS_DATA_DIR is set, searches only that folder. Otherwise
/// searches share/saltus next to the running program (build tree), then share/saltus next to the
/// program's folder (installation). The CMake function saltus_data() installs the files. Throws
/// InputError with the searched folders if the file is missing.
std::filesystem::path data_file(const std::string& name);

/// Folder of the running program. Empty if the system does not provide it.
std::filesystem::path program_folder();

/// The user's cache folder for downloads: saltus in XDG_CACHE_HOME, otherwise in ~/.cache. The
/// folder may not exist. Throws InputError if neither XDG_CACHE_HOME nor HOME is set.
std::filesystem::path cache_folder();

}  // namespace saltus
