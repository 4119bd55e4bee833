// The CSV of a survival map: written line by line, continued where it stopped.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problems/biped/survival/map_cells.hpp"

namespace saltus::walking {

inline constexpr const char* map_csv = "map.csv";           ///< the table, in the map's folder
inline constexpr const char* map_settings = "config.yaml";  ///< the settings of all its runs

/// `map.csv` in a folder, and beside it the settings with which it was made. If a cell occurs twice
/// the last line counts.
class MapFile {
 public:
  /// Creates both files, or continues the map that is there; one without a cell is begun anew.
  /// `settings` is all that decides about an outcome besides the cell, as YAML. Throws InputError
  /// if the folder cannot be used, holds a map with other settings (the first difference is named)
  /// or of another version, or if another process is at work on it.
  MapFile(const std::filesystem::path& folder, const std::string& settings);
  ~MapFile();
  MapFile(const MapFile&) = delete;
  MapFile& operator=(const MapFile&) = delete;

  /// What was there when the file was opened; half a line at the end, of a process that was
  /// killed, is cut off.
  const std::vector<MapRow>& rows() const { return rows_; }

  /// In the file, whatever happens to this process next. Throws InputError if the disk is full.
  void append(const MapRow& row);

 private:
  void read();

  std::filesystem::path path_;
  int file_ = -1;
  std::vector<MapRow> rows_;
};

}  // namespace saltus::walking
