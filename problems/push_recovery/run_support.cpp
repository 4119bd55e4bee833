#include "problems/push_recovery/run_support.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "framework/core/error.hpp"

namespace saltus::push_recovery {

std::optional<std::filesystem::path> urdf_of(const Config& config) {
  if (!config.urdf.empty()) return config.urdf;
  const char* fetched = std::getenv("SALTUS_ICUB_URDF");
  if (fetched != nullptr && *fetched != '\0' && std::filesystem::exists(fetched)) return fetched;
  return std::nullopt;
}

std::filesystem::path urdf_of_body(const Config& config) {
  const auto urdf = urdf_of(config);
  if (!urdf)
    throw InputError(
        "the whole body needs the robot's URDF, which was not fetched; name it with --urdf FILE");
  return *urdf;
}

void draw(const std::filesystem::path& results, const char* what, const std::string& script) {
  const std::string path = SALTUS_SOURCE_DIR "/problems/push_recovery/" + script;
  const std::string folder = results.string();
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    // The system's own python3 first: that is the one whose packages the set-up installs.
    for (const char* python : {"/usr/bin/python3", "python3"})
      execlp(python, python, path.c_str(), folder.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0 || status != 0)
    fmt::print(stderr, "no {}: python3 could not run {}\n", what, path);
}

}  // namespace saltus::push_recovery
