// Where the files lie that a program reads at run time: scripts that draw, recorded data.
#pragma once

#include <filesystem>
#include <string>

namespace saltus {

/// The file or folder that the source tree calls `name` ("robots/icub/fetch_icub_model"): in
/// the folder that SALTUS_DATA_DIR names if it is set, else in share/saltus beside the running
/// program (a build folder) or beside the folder that it lies in (an installation). CMake's
/// saltus_data() puts it there. Throws InputError naming where it was looked for.
std::filesystem::path data_file(const std::string& name);

/// The folder that the running program lies in; empty if the system does not tell.
std::filesystem::path program_folder();

/// The user's folder for what can be fetched again: saltus in XDG_CACHE_HOME, else in ~/.cache. It
/// may not exist. Throws InputError if there is neither variable.
std::filesystem::path cache_folder();

}  // namespace saltus
