// Runs one of the project's python scripts on a folder of results, without a shell.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace saltus {

/// `script` is what data_file() finds ("python/saltus/plot_trajectory.py"). Pictures are a
/// service: when the script cannot do its work, one sentence on the error stream says that there is
/// no `what` ("picture"), and the run goes on. Returns whether it did. Throws InputError
/// if its files cannot be written, on a full disk for example.
bool run_python_script(std::string_view script, const std::filesystem::path& results,
                       std::string_view what);

}  // namespace saltus
