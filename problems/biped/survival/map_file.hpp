// CSV file of a survival map, written line by line and continued after an interruption.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problems/biped/survival/map_cells.hpp"

namespace saltus::robots::walking {

inline constexpr const char* map_csv = "map.csv";           ///< table in the map's folder
inline constexpr const char* map_settings = "config.yaml";  ///< settings of all runs

/// `map.csv` in a folder, together with the settings of its runs. If a cell occurs twice, the last
/// line counts.
class MapFile {
 public:
  /// Creates both files, or continues an existing map. A map without cells is recreated.
  /// `settings`: all settings except those of the cell, as YAML. Throws InputError if the folder
  /// cannot be used, if another process uses it, or if it contains a map with different settings
  /// (the message names the first difference) or from a different version.
  MapFile(const std::filesystem::path& folder, const std::string& settings);
  ~MapFile();
  MapFile(const MapFile&) = delete;
  MapFile& operator=(const MapFile&) = delete;

  /// Rows in the file when it was opened. An incomplete last line of a killed process is removed.
  const std::vector<MapRow>& rows() const { return rows_; }

  /// Writes a row, which survives a crash of this process. Throws InputError if the disk is
  /// full.
  void append(const MapRow& row);

 private:
  void read();

  std::filesystem::path path_;
  int file_ = -1;
  std::vector<MapRow> rows_;
};

}  // namespace saltus::robots::walking
