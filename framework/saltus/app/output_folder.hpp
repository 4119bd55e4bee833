// Where a run leaves its results, such that nothing is ever half-written.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "saltus/app/csv_table.hpp"

namespace saltus {

/// A folder that is proved writable before any work begins, and comes into being with the first
/// file. Every file is written beside its final name and then renamed: a reader, or an interrupted
/// run, sees the old file or the new one. Everything that fails throws InputError.
class OutputFolder {
 public:
  /// Throws InputError naming the folder if files cannot be created in it.
  explicit OutputFolder(std::filesystem::path path);

  /// The folder.
  const std::filesystem::path& path() const { return path_; }

  /// These files of an earlier run go as soon as one is written: what two runs leave never lies
  /// side by side, and a run that writes nothing takes nothing.
  void clear_when_written(std::vector<std::string> names) { earlier_ = std::move(names); }
  /// When this folder was opened, by the clock of files.
  std::filesystem::file_time_type begin() const { return begin_; }

  /// A text as it is.
  void write(std::string_view name, std::string_view content) const;
  /// Indented JSON; numbers that are not finite become null, as JSON has no word for them.
  void write(std::string_view name, const nlohmann::ordered_json& value) const;
  /// A table as CSV.
  void write(std::string_view name, const CsvTable& table) const;

 private:
  std::filesystem::path path_;
  std::filesystem::file_time_type begin_;
  mutable std::vector<std::string> earlier_;
};

/// The folder of a file that `flag` names, proved writable before the work begins that fills the
/// file. Throws InputError if it cannot be, or if the name is a folder's.
OutputFolder folder_of_file(std::string_view flag, const std::filesystem::path& file);

}  // namespace saltus
