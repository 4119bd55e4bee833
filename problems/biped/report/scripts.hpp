// Calls of the Python package that draw a run, and the list of files in its folder.
#pragma once

#include <filesystem>
#include <string>

#include "saltus/app/program.hpp"

namespace saltus::robots::walking {

/// Runs a module of saltus.walking (python/) on a folder of results, without a shell. Pictures are
/// optional: if `what` cannot be drawn, a message goes to the error stream and the program
/// continues.
void draw(const std::filesystem::path& results, const char* what, const std::string& module);

/// Lists the files that a run wrote to its folder and how to open them, one line each. Files older
/// than `begin` belong to another run and are not listed.
std::string results_text(const std::filesystem::path& results,
                         std::filesystem::file_time_type begin);

/// `saltus movie DIR`. Prints a message and returns `not_applicable` if Chromium is missing or
/// draws nothing.
Verb movie_verb();

}  // namespace saltus::robots::walking
