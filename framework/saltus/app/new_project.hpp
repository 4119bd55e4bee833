// A project of a user's own, made from the templates that are installed with the program.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "saltus/app/program.hpp"

namespace saltus {

/// What a new project begins with: the folder framework/templates/NAME.
struct ProjectKind {
  std::string name;     ///< as --kind takes it
  std::string summary;  ///< a sentence, for its README and for help
};
/// All kinds, in the order of the help.
std::span<const ProjectKind> project_kinds();

/// Makes the folder with all files, or nothing. Its last part is the project's name, in which a
/// letter begins and letters, digits, _ and - follow. Throws InputError: another name, one that
/// CMake has taken, something that exists already, a folder that cannot be written, no templates.
void make_project(const std::filesystem::path& folder, const ProjectKind& kind);

/// `saltus new NAME [--kind KIND]`
Verb new_verb();

}  // namespace saltus
