#include "saltus/robots/icub/icub.hpp"

#include <fmt/format.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"

namespace saltus::robots {
namespace {

namespace fs = std::filesystem;

constexpr const char* package = "icub-models 3.2.0";
// in the cache; keep the version equal to that in the script
constexpr const char* folder = "icub-models-3.2.0";
constexpr const char* urdf = "share/iCub/robots/iCubGazeboV2_5/model.urdf";

const char* named_urdf() {
  const char* named = std::getenv("SALTUS_ICUB_URDF");
  return named != nullptr && *named != '\0' ? named : nullptr;
}

// Runs the script. Its output goes to the error stream, to keep the results clean.
bool run(const fs::path& script, const fs::path& argument) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
#ifdef __linux__
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // ends with the parent process
#endif
    dup2(STDERR_FILENO, STDOUT_FILENO);
    execl(script.c_str(), script.c_str(), argument.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

}  // namespace

std::optional<fs::path> find_icub_urdf() {
  std::error_code absent;
  if (const char* named = named_urdf())
    return fs::exists(named, absent) ? std::optional<fs::path>(named) : std::nullopt;
  if (std::getenv("XDG_CACHE_HOME") == nullptr && std::getenv("HOME") == nullptr)
    return std::nullopt;
  const fs::path cached = cache_folder() / folder / urdf;
  return fs::exists(cached, absent) ? std::optional<fs::path>(cached) : std::nullopt;
}

fs::path fetch_icub_urdf(const std::function<void(const std::string&)>& say) {
  if (const auto found = find_icub_urdf()) return *found;
  if (const char* named = named_urdf())
    throw InputError(fmt::format(
        "SALTUS_ICUB_URDF names {} as the URDF of iCub, but there is no such file", named));
  const fs::path target = cache_folder() / folder;
  const fs::path script = data_file("robots/icub/fetch_icub_model");
  say(fmt::format(
      "Fetching the official model of iCub ({}, 18 MB, licence CC BY-SA 4.0) into {} ...", package,
      target.string()));
  if (!run(script, target) || !find_icub_urdf())
    throw InputError(
        fmt::format("the URDF of iCub could not be downloaded ({} from PyPI); give one with "
                    "--robot.urdf FILE or SALTUS_ICUB_URDF",
                    package));
  return *find_icub_urdf();
}

}  // namespace saltus::robots
