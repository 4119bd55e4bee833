#include "saltus/app/python_script.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>

#include "saltus/app/data_file.hpp"
#include "saltus/core/error.hpp"

namespace saltus {
namespace {

constexpr int script_has_said_why = 3;  // python/saltus/drawing.py
constexpr int files_not_written = 4;    // python/saltus/on_folder.py: said too

}  // namespace

bool run_python_script(std::string_view script, const std::filesystem::path& results,
                       std::string_view what) {
  std::string path;
  try {
    path = data_file(std::string(script)).string();
  } catch (const InputError& error) {
    fmt::print(stderr, "no {}: {}\n", what, error.what());
    return false;
  }
  const std::string folder = results.string();
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    // The system's own python3 first: that is the one whose packages the set-up installs.
    for (const char* python : {"/usr/bin/python3", "python3"})
      execlp(python, python, "-B", path.c_str(), folder.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  const bool ended = child > 0 && waitpid(child, &status, 0) >= 0 && WIFEXITED(status);
  if (ended && WEXITSTATUS(status) == 0) return true;
  if (ended && WEXITSTATUS(status) == files_not_written)
    throw InputError(fmt::format("no {}: the files cannot be written into '{}'", what, folder));
  if (!ended || WEXITSTATUS(status) != script_has_said_why)
    fmt::print(stderr, "no {}: python3 could not run {}\n", what, path);
  return false;
}

}  // namespace saltus
