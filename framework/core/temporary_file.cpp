#include "saltus/core/temporary_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <random>
#include <string>
#include <system_error>

namespace saltus {

namespace fs = std::filesystem;

fs::path temporary_beside(const fs::path& path) {
  std::random_device random;
  return path.parent_path() /
         fmt::format(".{}.{:08x}.{}.part", path.filename().string(), random(), ::getpid());
}

bool make_private_file(const fs::path& file) {
  const int descriptor =
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  return descriptor >= 0 && ::close(descriptor) == 0;
}

void publish_file(const fs::path& temporary, const fs::path& file, std::error_code& error) {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  std::error_code has_no_rights;  // a file system of another kind
  fs::permissions(temporary, static_cast<fs::perms>(0666U & ~mask), has_no_rights);
  fs::rename(temporary, file, error);
}

void remove_orphans(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with('.') || !name.ends_with(".part")) continue;
    const fs::path number = entry.path().stem().extension();  // .NAME.RANDOM.PROCESS.part
    const int process = std::atoi(number.c_str() + (number.empty() ? 0 : 1));
    const bool is_over = process > 0 && ::kill(process, 0) != 0 && errno == ESRCH;
    if (is_over) fs::remove(entry.path(), error);
  }
}

}  // namespace saltus
