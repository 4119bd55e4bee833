// Runs Python on a folder of results, without a shell: modules of the package saltus (python/),
// scripts.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace saltus {

/// Runs `module` of the package saltus ("saltus.plot") on a folder and further words. Pictures are
/// a service: when the module cannot do its work, one sentence on the error stream says that there
/// is no `what` ("picture"), and the run goes on. Returns whether it did. Throws InputError if its
/// files cannot be written, on a full disk for example.
bool run_python_module(std::string_view module, const std::filesystem::path& results,
                       std::string_view what, std::span<const std::string> more = {});

/// The same for a script that data_file() finds ("problems/mine/plot.py"); it may import saltus.
bool run_python_script(std::string_view script, const std::filesystem::path& results,
                       std::string_view what);

/// Why the limits of the process leave no room for python3 and its packages, one sentence; empty if
/// they do. With less memory numpy's OpenBLAS would wait for ever.
std::string refusal_of_python();

}  // namespace saltus
