// Repeats a run and compares the results bit by bit.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "saltus/app/program.hpp"

namespace saltus {

/// Comparison of two files with the same name.
struct FileComparison {
  std::string name;      ///< name in both folders
  bool is_same = false;  ///< equal except for computing times
  std::string text;      ///< a sentence: equal, or the first difference
};

/// Compares all tables (.csv) except columns of computing times ("solve time [s]"), summary.json
/// except computing times, version and commit, and robot.json if both folders have it.
std::vector<FileComparison> compare_runs(const std::filesystem::path& before,
                                         const std::filesystem::path& after);

/// `saltus rerun DIR [--out DIR]`: returns `differs` if anything differs. Without --out the new run
/// is kept only in that case.
ExitStatus rerun(std::span<const std::string> arguments, std::span<const ProblemEntry> problems);

}  // namespace saltus
