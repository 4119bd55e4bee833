// In which formats a run leaves its tables: CSV, and what other people's tools read.
#pragma once

#include <filesystem>
#include <string>

namespace saltus {

class Settings;

/// CSV is always written: pictures and `saltus rerun` read it.
struct LogFormats {
  std::string names = "csv";  ///< "csv", "mat", "mcap" in any order, separated by commas
};

/// `log.formats`; other names are refused.
void declare_log_formats(Settings& settings, LogFormats& formats);

/// What is wrong with the names, after "... must"; empty if nothing is.
std::string complaint_of_formats(const LogFormats& formats);

/// Writes run.mat and run.mcap of the folder's tables if they are wanted, by the Python package;
/// those written are told; a sentence on the error stream says which Python package is missing.
/// Returns whether all is there that is wanted. Throws InputError if files cannot be written.
bool write_logs(const LogFormats& formats, const std::filesystem::path& results);

}  // namespace saltus
