// Runs Python on a results folder without a shell: modules of the package saltus (python/) and
// scripts.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace saltus {

/// Runs `module` of the package saltus ("saltus.plot") with a folder and further arguments. Plots
/// are optional: if the module fails, one sentence on the error stream reports that there is no
/// `what` ("picture"), and the run continues. Returns true on success. Throws InputError if its
/// files cannot be written, for example on a full disk.
bool run_python_module(std::string_view module, const std::filesystem::path& results,
                       std::string_view what, std::span<const std::string> more = {});

/// The same for a script found by data_file() ("problems/mine/plot.py"). The script may import
/// saltus.
bool run_python_script(std::string_view script, const std::filesystem::path& results,
                       std::string_view what);

/// An error message if process limits leave too little memory for python3 and its packages,
/// otherwise empty. With less memory numpy's OpenBLAS would wait forever.
std::string python_limit_error();

}  // namespace saltus
