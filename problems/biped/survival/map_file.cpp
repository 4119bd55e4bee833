#include "problems/biped/survival/map_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

#include "saltus/app/program.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/file_content.hpp"
#include "saltus/core/text.hpp"

namespace saltus::robots::walking {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::error_code absent;
  if (!fs::exists(file, absent)) return {};
  if (!fs::is_regular_file(file, absent))
    throw InputError(fmt::format("'{}' is not a file; choose another --out", file.string()));
  return file_content(file);
}

// Flattens nested YAML: "  gamma: [0, 0]  # unit" becomes "weights.gamma: [0, 0]".
std::vector<std::string> flat_lines(const std::string& yaml) {
  std::vector<std::string> lines, sections;
  std::istringstream stream(yaml);
  for (std::string line; std::getline(stream, line);) {
    line.resize(std::min(line.find("  # "), line.size()));
    const std::size_t indent = line.find_first_not_of(' ');
    if (indent == std::string::npos || line[indent] == '#') continue;
    const std::size_t colon = line.find(':', indent);
    if (colon == std::string::npos) continue;
    sections.resize(indent / 2);  // two spaces per level
    sections.push_back(line.substr(indent, colon - indent));
    if (colon + 1 < line.size())
      lines.push_back(fmt::format("{}{}", fmt::join(sections, "."), line.substr(colon)));
  }
  return lines;
}

// The first setting that differs between the stored map and this one.
std::string difference(const std::string& there, const std::string& here) {
  const std::vector<std::string> old_lines = flat_lines(there), new_lines = flat_lines(here);
  const auto lacks = [](const std::vector<std::string>& lines, const std::string& line) {
    return std::find(lines.begin(), lines.end(), line) == lines.end();
  };
  for (const std::string& line : new_lines) {
    if (!lacks(old_lines, line)) continue;
    const std::string key = line.substr(0, line.find(": ") + 2);
    for (const std::string& old : old_lines)
      if (old.starts_with(key))
        return fmt::format("'{}' there, '{}' now", shortened(old), shortened(line));
    return fmt::format("'{}' is new", shortened(line));
  }
  for (const std::string& line : old_lines)
    if (lacks(new_lines, line)) return fmt::format("'{}' is missing now", shortened(line));
  return "the robot or the comments differ";
}

}  // namespace

MapFile::MapFile(const fs::path& folder, const std::string& settings) : path_(folder / map_csv) {
  const OutputFolder output(folder);
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path stamp = folder / map_settings;
  const bool is_begun = content_of(path_).size() > map_header().size() + 1;
  if (is_begun) {
    const std::string there = content_of(stamp);
    if (there != settings)
      throw InputError(
          there.empty()
              ? fmt::format(
                    "'{}' contains a map, but its settings ({}) are missing; choose another "
                    "--out",
                    folder.string(), map_settings)
              : fmt::format(
                    "'{}' contains a map with different settings ({}); choose another --out",
                    folder.string(), difference(there, settings)));
  } else if (fs::exists(stamp, error) && !fs::exists(path_, error)) {
    throw InputError(fmt::format("'{}' contains results of another kind; choose another --out",
                                 folder.string()));
  }
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file_ < 0)
    throw InputError(fmt::format("cannot write '{}': {}", path_.string(), std::strerror(errno)));
  // The child processes of a killed process end slightly later and hold the lock until then.
  bool is_ours = ::flock(file_, LOCK_EX | LOCK_NB) == 0;
  for (int tries = 0; !is_ours && tries < 10; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    is_ours = ::flock(file_, LOCK_EX | LOCK_NB) == 0;
  }
  if (!is_ours) {
    ::close(file_);
    throw InputError(fmt::format("another process is writing '{}'", path_.string()));
  }
  try {
    output.write(map_settings, std::string_view(settings));
    read();
  } catch (...) {
    ::close(file_);
    throw;
  }
}

MapFile::~MapFile() { ::close(file_); }

void MapFile::read() {
  std::string content = content_of(path_);
  const std::size_t whole = content.find_last_of('\n') + 1;  // 0 if there is none
  if (whole != content.size() && ::ftruncate(file_, static_cast<off_t>(whole)) != 0)
    throw InputError(fmt::format("cannot write '{}': {}", path_.string(), std::strerror(errno)));
  content.resize(whole);
  const std::string head = map_header() + "\n";
  if (content.empty()) {
    if (::write(file_, head.data(), head.size()) != static_cast<ssize_t>(head.size()))
      throw InputError(fmt::format("cannot write '{}'", path_.string()));
    return;
  }
  if (!content.starts_with(head))
    throw InputError(fmt::format("'{}' has different columns: it was written by another version",
                                 path_.string()));
  std::istringstream stream(content.substr(head.size()));
  int number = 1;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const std::optional<MapRow> row = from_line(line);
    if (!row)
      throw InputError(
          fmt::format("{}:{} cannot be read: '{}'", path_.string(), number, shortened(line)));
    rows_.push_back(*row);
  }
}

void MapFile::append(const MapRow& row) {
  const std::string line = to_line(row) + "\n";
  if (::write(file_, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    throw InputError(fmt::format("cannot write '{}': {}", path_.string(), std::strerror(errno)));
}

}  // namespace saltus::robots::walking
