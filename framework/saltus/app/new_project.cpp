#include "saltus/app/new_project.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "saltus/app/option_parser.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/app/template_file.hpp"
#include "saltus/app/version.hpp"
#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/temporary_file.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

constexpr const char* summary =
    "creates a project that uses the installed library: solves, plots, runs in closed "
    "loop";

// Target names reserved by CMake, the package that the project finds, and the project's own names.
constexpr std::array taken{"all",
                           "clean",
                           "depend",
                           "edit_cache",
                           "help",
                           "install",
                           "list_install_components",
                           "package",
                           "package_source",
                           "problem",
                           "problem_test",
                           "rebuild_cache",
                           "saltus",
                           "test"};

void check_name(const std::string& name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto may_follow = [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  if (name.empty() || !is_letter(name.front()) || !std::ranges::all_of(name, may_follow))
    throw InputError(fmt::format(
        "new: '{}' is not a valid project name: expected a letter, then letters, digits, _ and "
        "-",
        shortened(name)));
  if (name.size() > 64) throw InputError("new: a project name has at most 64 characters");
  if (std::ranges::find(taken, name) != taken.end())
    throw InputError(fmt::format(
        "new: '{}' is not a valid project name: CMake or Saltus uses it already", name));
}

// "0.3": the version for find_package.
std::string minor_version() {
  const std::string whole = version();
  return whole.substr(0, whole.find('.', whole.find('.') + 1));
}

// Removes a trailing slash: "cart/" becomes "cart".
fs::path without_slash(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

void write_files(const fs::path& templates, const fs::path& folder, const Marks& marks) {
  for (const fs::directory_entry& file : fs::directory_iterator(templates)) {
    const fs::path made = folder / file.path().filename();
    std::ofstream stream(made, std::ios::binary);
    stream << fill_template(file.path(), marks);
    stream.close();
    if (!stream) throw InputError(fmt::format("new: '{}' cannot be written", made.string()));
    fs::permissions(made, file.status().permissions() | fs::perms::owner_write);
  }
}

// The CMake options that find the library, or a message if it is not installed.
std::string how_to_build(const std::string& name, const fs::path& folder) {
  const fs::path prefix = program_folder().parent_path();
  bool is_installed = false;
  std::error_code absent;
  for (const fs::directory_entry& entry : fs::directory_iterator(prefix / "lib", absent))
    is_installed = is_installed || fs::exists(entry.path() / "cmake/saltus", absent);
  is_installed = is_installed || fs::exists(prefix / "lib/cmake/saltus", absent);
  const std::string hint = !is_installed      ? " -D CMAKE_PREFIX_PATH=PREFIX"
                           : prefix != "/usr" ? " -D CMAKE_PREFIX_PATH=" + prefix.string()
                                              : "";
  std::string text = fmt::format("{}: README.md describes the files\n", folder.string());
  if (!is_installed)
    text += fmt::format(
        "This program is not installed: run `cmake --install {} --prefix PREFIX` "
        "first.\n",
        program_folder().string());
  return text + fmt::format("  cd {}\n  cmake -S . -B build{}\n  cmake --build build\n  build/{}\n",
                            folder.string(), hint, name);
}

}  // namespace

std::span<const ProjectKind> project_kinds() {
  static const std::vector<ProjectKind> kinds{
      {"trajectory",
       "A pendulum swings up with minimum torque: one optimal trajectory, then control "
       "by solving again from the measured state."},
      {"controller",
       "A controller balances a pole on a cart: receding horizon, moving target, "
       "a push, noise."},
      {"switched",
       "A sledge slides from ice onto gravel: dynamics with a state-dependent switch, planned "
       "and controlled through the switch."}};
  return kinds;
}

void make_project(const fs::path& folder, const ProjectKind& kind) {
  const fs::path whole = without_slash(folder);
  const std::string name = whole.filename().string();
  check_name(name);
  std::error_code error;
  if (fs::exists(fs::symlink_status(whole, error)))
    throw InputError(fmt::format("new: '{}' exists already; nothing was changed", folder.string()));
  const fs::path common = data_file("framework/templates/common"),
                 own = data_file("framework/templates/" + kind.name);
  const Marks marks{{"@NAME@", name}, {"@VERSION@", minor_version()}, {"@SUMMARY@", kind.summary}};

  const fs::path partial = temporary_path(whole);
  try {
    fs::create_directory(partial);
    write_files(common, partial, marks);
    write_files(own, partial, marks);
    fs::rename(partial, whole);
  } catch (const fs::filesystem_error& problem) {
    fs::remove_all(partial, error);
    throw InputError(
        fmt::format("new: '{}' cannot be created: {}", folder.string(), problem.code().message()));
  } catch (...) {
    fs::remove_all(partial, error);
    throw;
  }
}

Verb new_verb() {
  return {"new", summary, [](std::span<const std::string> arguments) {
            std::string folder, kind = "trajectory", wanted = kind;
            std::vector<std::string> names;
            for (const ProjectKind& known : project_kinds()) names.push_back(known.name);
            OptionParser parser("new", summary);
            parser.word("name", "name of the project, or its folder", folder)
                .option("--kind", "KIND", join_names(names) + "; default trajectory", wanted);
            if (parser.prints_help(arguments)) {
              for (const ProjectKind& known : project_kinds())
                fmt::print("  {:<10}  {}\n", known.name, known.summary);
              return ExitStatus::ok;
            }
            if (folder.empty()) throw InputError("new needs the name of the project");
            Settings settings;
            settings.choice("kind", kind, names, "template of the project");
            settings.apply({flag_assignment("kind", wanted)});
            const auto chosen = std::ranges::find(project_kinds(), kind, &ProjectKind::name);
            make_project(folder, *chosen);
            const std::string name = without_slash(folder).filename().string();
            fmt::print("{}", how_to_build(name, folder));
            return ExitStatus::ok;
          }};
}

}  // namespace saltus
