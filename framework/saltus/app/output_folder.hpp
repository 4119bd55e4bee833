// Output folder of a run, without partially written files.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "saltus/core/csv_table.hpp"

namespace saltus {

/// A folder that is checked to be writable before any work begins, and created with the first file.
/// Every file is written to a temporary name and renamed: a reader, also after an interrupted run,
/// sees the old file or the new one. All errors throw InputError.
class OutputFolder {
 public:
  /// Throws InputError naming the folder if files cannot be created in it.
  explicit OutputFolder(std::filesystem::path path);

  /// Path of the folder.
  const std::filesystem::path& path() const { return path_; }

  /// Marks files of an earlier run for removal before the first write, so that files of two runs
  /// are never mixed. A run that writes nothing removes nothing.
  void clear_when_written(std::vector<std::string> names) { earlier_ = std::move(names); }
  /// Time when this folder was opened, by the file clock.
  std::filesystem::file_time_type begin() const { return begin_; }

  /// Writes a text unchanged.
  void write(std::string_view name, std::string_view content) const;
  /// Writes indented JSON. Non-finite numbers become null.
  void write(std::string_view name, const nlohmann::ordered_json& value) const;
  /// Writes a table as CSV.
  void write(std::string_view name, const CsvTable& table) const;

 private:
  std::filesystem::path path_;
  std::filesystem::file_time_type begin_;
  mutable std::vector<std::string> earlier_;
};

/// Output folder of the file given by `flag`, checked to be writable. Throws InputError if it is
/// not, or if the name is that of a folder.
OutputFolder folder_of_file(std::string_view flag, const std::filesystem::path& file);

}  // namespace saltus
