#include "saltus/core/temporary_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <system_error>

#include "saltus/core/error.hpp"

namespace saltus {

namespace fs = std::filesystem;

namespace {

// Host name without dots, at most 16 characters. whole_file.py uses the same rule.
std::string short_host_name() {
  char name[256] = {};
  if (::gethostname(name, sizeof(name) - 1) != 0 || name[0] == '\0') return "host";
  std::string host(name, std::min<std::size_t>(std::strlen(name), 16));
  std::replace(host.begin(), host.end(), '.', '-');
  return host;
}

}  // namespace

fs::path temporary_path(const fs::path& path) {
  std::random_device random;
  const std::string name = path.filename().string().substr(0, 160);  // total below NAME_MAX
  return path.parent_path() /
         fmt::format(".{}.{:08x}.{}.{}.part", name, random(), short_host_name(), ::getpid());
}

bool make_private_file(const fs::path& file) {
  const int descriptor =
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  return descriptor >= 0 && ::close(descriptor) == 0;
}

void write_atomically(const fs::path& file, std::string_view content, std::error_code& error) {
  const fs::path temporary = temporary_path(file);
  error.clear();
  errno = 0;
  std::ofstream stream;
  if (make_private_file(temporary)) stream.open(temporary, std::ios::binary | std::ios::trunc);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  std::error_code ignored;
  if (!stream.good()) {
    error = {errno != 0 ? errno : EIO, std::generic_category()};
  } else {
    const mode_t mask = ::umask(0);
    ::umask(mask);
    fs::permissions(temporary, static_cast<fs::perms>(0666U & ~mask), ignored);  // best effort
    fs::rename(temporary, file, error);
  }
  if (error) fs::remove(temporary, ignored);
}

void write_atomically(const fs::path& file, std::string_view content) {
  std::error_code error;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
  write_atomically(file, content, error);
  if (error) throw InputError(fmt::format("cannot write '{}': {}", file.string(), error.message()));
}

void remove_orphans(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with('.') || !name.ends_with(".part")) continue;
    const fs::path of_process = entry.path().stem();  // .NAME.RANDOM.HOST.PROCESS
    const std::string number = of_process.extension().string();
    const std::string host = of_process.stem().extension().string();  // includes the dot
    if (number.empty() || host.empty() || host.substr(1) != short_host_name()) continue;
    const int process = std::atoi(number.c_str() + 1);
    const bool is_over = process > 0 && ::kill(process, 0) != 0 && errno == ESRCH;
    if (is_over) fs::remove(entry.path(), error);
  }
}

}  // namespace saltus
