// Formats of the tables of a run: CSV, and formats of other tools.
#pragma once

#include <filesystem>
#include <string>

namespace saltus {

class Settings;

/// CSV is always written: the plots and `saltus rerun` read it.
struct LogFormats {
  std::string names = "csv";  ///< "csv", "mat", "mcap" in any order, separated by commas
};

/// Declares `log.formats`, which rejects unknown names.
void declare_log_formats(Settings& settings, LogFormats& formats);

/// Error of the names, after "... must"; empty if they are valid.
std::string complaint_of_formats(const LogFormats& formats);

/// Writes run.mat and run.mcap from the tables of the folder as requested, with the Python package,
/// and prints the names of the files. If a Python package is missing, prints a sentence to the
/// error stream. Returns true if all requested files exist. Throws InputError if files cannot be
/// written.
bool write_logs(const LogFormats& formats, const std::filesystem::path& results);

}  // namespace saltus
