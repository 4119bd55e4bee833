#include "saltus/app/program.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <climits>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "saltus/core/error.hpp"
#include "saltus/core/temporary_file.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

// A name as long as the longest file name of a run, including the additions of a temporary name.
constexpr const char* longest_file_name =
    ".latency_by_provenance.json.01234567.sixteen-long-host.4194304.part";

// The folder itself or its nearest existing parent.
fs::path nearest_existing(fs::path folder) {
  std::error_code error;
  while (!fs::exists(fs::symlink_status(folder, error)) && folder.has_relative_path()) {
    folder = folder.parent_path();
  }
  return folder;
}

}  // namespace

OutputFolder::OutputFolder(fs::path path) : path_(std::move(path)) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("output folder '{}' {}", shortened(path_.string()), why));
  };
  if (path_.empty()) throw InputError("the name of the output folder is empty");

  std::error_code error;
  const fs::path existing = nearest_existing(fs::absolute(path_, error));
  if (!fs::is_directory(existing, error)) {
    refuse(fmt::format("cannot be used: '{}' is not a folder", existing.string()));
  }
  // Rejects a name that is too long before the run, not when the last file is written.
  const fs::path longest = fs::absolute(path_, error) / longest_file_name;
  const auto most = static_cast<std::size_t>(::pathconf(existing.c_str(), _PC_NAME_MAX));
  for (const fs::path& part : longest)
    if (part.native().size() > most)
      refuse(fmt::format("cannot be created: a name has at most {} bytes", most));
  if (longest.native().size() >= PATH_MAX)
    refuse(fmt::format("cannot be created: the path of a file has less than {} bytes", PATH_MAX));
  // Permission bits are not reliable (read-only file systems, root). A file is created and removed
  // instead.
  const fs::path probe = temporary_path(existing / "saltus_probe");
  const bool writable = make_private_file(probe) && std::ofstream(probe).put('\n').flush().good();
  begin_ = fs::last_write_time(probe, error);  // by the clock of the file system, which may differ
  fs::remove(probe, error);
  if (!writable) refuse("is not writable");
  remove_orphans(path_);
}

void OutputFolder::write(std::string_view name, std::string_view content) const {
  write_atomically(path_ / name, content);
  std::error_code ignored;
  for (const std::string& earlier : std::exchange(earlier_, {}))
    if (earlier != name) fs::remove(path_ / earlier, ignored);
}

void OutputFolder::write(std::string_view name, const nlohmann::ordered_json& value) const {
  using Handler = nlohmann::ordered_json::error_handler_t;
  write(name, std::string_view(value.dump(2, ' ', false, Handler::replace) + "\n"));
}

void OutputFolder::write(std::string_view name, const CsvTable& table) const {
  write(name, std::string_view(table.text()));
}

OutputFolder folder_of_file(std::string_view flag, const fs::path& file) {
  std::error_code error;
  if (!file.has_filename() || fs::is_directory(file, error))
    throw InputError(fmt::format("{} needs a file, but '{}' is a folder", flag, file.string()));
  return OutputFolder(file.has_parent_path() ? file.parent_path() : ".");
}

}  // namespace saltus
