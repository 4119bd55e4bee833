// A run that was made is made again, and compared to the last bit.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "saltus/app/problem_registry.hpp"

namespace saltus {

/// Two files of one name in two runs.
struct FileComparison {
  std::string name;      ///< in both folders
  bool is_same = false;  ///< but for computing times
  std::string text;      ///< a sentence: the same, or where they differ first
};

/// Every table (.csv) of the first folder beside that of the second, but for columns of computing
/// times ("solve time [s]"), summary.json but for entries of computing times, version and commit,
/// and robot.json where both have it.
std::vector<FileComparison> compare_runs(const std::filesystem::path& before,
                                         const std::filesystem::path& after);

/// `saltus rerun DIR [--out DIR]`: `differs` if anything does. Without --out the new run is kept
/// only then.
ExitStatus rerun(std::span<const std::string> arguments, std::span<const ProblemEntry> problems);

}  // namespace saltus
