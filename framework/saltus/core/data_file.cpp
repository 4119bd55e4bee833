#include "saltus/core/data_file.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

// Empty variables count as unset, as in the XDG specification.
const char* variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0' ? value : nullptr;
}

}  // namespace

fs::path data_file(const std::string& name) {
  std::vector<fs::path> folders;
  if (const char* named = variable("SALTUS_DATA_DIR")) {
    folders = {named};
  } else {
    const fs::path program = program_folder();
    folders = {program / "share/saltus", program.parent_path() / "share/saltus"};
  }
  for (const fs::path& folder : folders) {
    std::error_code absent;
    if (fs::exists(folder / name, absent)) return folder / name;
  }
  std::string text = folders.front().string();
  for (std::size_t i = 1; i < folders.size(); ++i) text += " or " + folders[i].string();
  throw InputError(fmt::format(
      "{} is not in {}; set SALTUS_DATA_DIR to the folder share/saltus of an installation", name,
      text));
}

fs::path program_folder() {
  std::error_code unknown;
  return fs::read_symlink("/proc/self/exe", unknown).parent_path();
}

fs::path cache_folder() {
  if (const char* cache = variable("XDG_CACHE_HOME")) return fs::path(cache) / "saltus";
  if (const char* home = variable("HOME")) return fs::path(home) / ".cache/saltus";
  throw InputError("there is no cache folder: set XDG_CACHE_HOME or HOME");
}

}  // namespace saltus
