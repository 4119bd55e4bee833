#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "tests/fuzz/targets.hpp"

// Known leaks of third-party libraries that refuse a file, some kB each. urdfdom creates a cycle of
// shared pointers. Assimp leaks the partial mesh of a text STL. Its stacks have no symbols, so the
// whole library is suppressed.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:urdf::parseURDF\nleak:libassimp.so\n";
}

namespace saltus::fuzz {
namespace {

constexpr std::size_t longest_sentence =
    2000;  // characters; messages truncate names but may show long file names

[[noreturn]] void give_up(const std::string& why) {
  fmt::print(stderr, "{}\n", why);
  std::abort();
}

void judge(const std::string& sentence) {
  require(!sentence.empty(), "rejected without a message");
  require(sentence.size() <= longest_sentence,
          fmt::format("a sentence of {} characters: {} ...", sentence.size(),
                      sentence.substr(0, longest_sentence)));
}

}  // namespace

void require(bool holds, const std::string& what) {
  if (!holds) give_up(what);
}

const Target& target(const std::string& name) {
  std::vector<std::string> names;
  for (const Target& one : targets()) {
    if (one.name == name) return one;
    names.push_back(one.name);
  }
  throw InputError(fmt::format("no reader '{}'; the readers are {}", name, join_names(names)));
}

void run(const Target& target, Bytes bytes) {
  try {
    target.read(bytes);
  } catch (const InputError& error) {
    judge(error.what());
  } catch (const std::exception& error) {
    give_up(fmt::format("{}: not an InputError but: {}", target.name, error.what()));
  }
}

const std::filesystem::path& own_folder() {
  struct Folder {
    std::filesystem::path path;
    Folder() {
      std::error_code absent;
      const std::filesystem::path memory = "/dev/shm";
      const bool has_memory = ::access(memory.c_str(), W_OK) == 0;
      std::string name = ((has_memory ? memory : std::filesystem::temp_directory_path(absent)) /
                          "saltus-fuzz-XXXXXX")
                             .string();
      require(::mkdtemp(name.data()) != nullptr, "cannot create a temporary folder");
      path = name;
    }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  return folder.path;
}

std::filesystem::path file_with(Bytes bytes, const std::string& name) {
  const std::filesystem::path path = own_folder() / name;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  require(file >= 0, "the temporary file cannot be made");
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t count = ::write(file, bytes.data() + written, bytes.size() - written);
    require(count > 0, "the temporary file cannot be written");
    written += static_cast<std::size_t>(count);
  }
  ::close(file);
  return path;
}

}  // namespace saltus::fuzz
