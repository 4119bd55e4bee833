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

namespace saltus::fuzz {
namespace {

constexpr std::size_t longest_sentence =
    2000;  // characters; names in it are cut, files may be long

[[noreturn]] void give_up(const std::string& why) {
  fmt::print(stderr, "{}\n", why);
  std::abort();
}

void judge(const std::string& sentence) {
  require(!sentence.empty(), "refused without a word");
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
  throw InputError(fmt::format("no reader '{}'; there are {}", name, join_names(names)));
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

TemporaryFile::TemporaryFile(Bytes bytes, const std::string& extension) {
  std::string name = (std::filesystem::temp_directory_path() / "saltus-fuzz-XXXXXX").string();
  name += extension;
  const int file = ::mkstemps(name.data(), static_cast<int>(extension.size()));
  require(file >= 0, "no temporary file can be made");
  const auto* data = reinterpret_cast<const char*>(bytes.data());
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t count = ::write(file, data + written, bytes.size() - written);
    require(count > 0, "the temporary file cannot be written");
    written += static_cast<std::size_t>(count);
  }
  ::close(file);
  path_ = name;
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace saltus::fuzz
