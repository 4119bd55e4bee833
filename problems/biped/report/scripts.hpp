// What of the Python package draws a run, and what lies in its folder then.
#pragma once

#include <filesystem>
#include <string>

#include "saltus/app/program.hpp"

namespace saltus::walking {

/// Runs a module of saltus.walking (python/) on a folder of results, without a shell. Pictures
/// are a service: the absence of `what` is said on the error stream, not fatal.
void draw(const std::filesystem::path& results, const char* what, const std::string& module);

/// The files that a run left in its folder and how to open them, one line each. Files that were
/// there before `begin` are of another run and not listed.
std::string results_text(const std::filesystem::path& results,
                         std::filesystem::file_time_type begin);

/// `saltus movie DIR`. `not_applicable` if Chromium is not there or draws nothing, which is said.
Verb movie_verb();

}  // namespace saltus::walking
