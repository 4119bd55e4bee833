// Creates a user project from the installed templates.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "saltus/app/program.hpp"

namespace saltus {

/// Template of a new project: the folder framework/templates/NAME.
struct ProjectKind {
  std::string name;     ///< value of --kind
  std::string summary;  ///< a sentence for README and help
};
/// All kinds, in the order of the help.
std::span<const ProjectKind> project_kinds();

/// Creates the folder with all files, or nothing. Its last part is the project name: a letter, then
/// letters, digits, _ and -. Throws InputError for an invalid name, a name reserved by CMake, an
/// existing path, a folder that cannot be written, or missing templates.
void make_project(const std::filesystem::path& folder, const ProjectKind& kind);

/// `saltus new NAME [--kind KIND]`
Verb new_verb();

}  // namespace saltus
