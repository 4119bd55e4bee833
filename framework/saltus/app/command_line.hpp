// What the user asked for on the command line of a program.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "saltus/app/assignment.hpp"

namespace saltus {

/// `saltus run PROBLEM [--config FILE] [--set KEY=VALUE]... [--out DIR] [--KEY VALUE]...
/// [--quiet] [--json] [--print-config] [--print-schema]`, taken apart. A flag that is not one of
/// these names a setting: `--KEY VALUE`, `--KEY=VALUE` and `--set KEY=VALUE` mean the same, and
/// `--KEY` alone switches a yes-or-no setting on. Whether the problem has such a setting is for its
/// `Settings` to say.
struct RunRequest {
  std::string problem;                               ///< name or alias of what is to run
  std::optional<std::filesystem::path> config_file;  ///< of --config
  std::vector<Assignment> assignments;               ///< of --set and other flags, in their order
  std::filesystem::path out;  ///< results/PROBLEM unless --out says otherwise
  bool quiet = false;         ///< print nothing but errors
  bool json = false;          ///< print the summary as JSON in place of words
  bool help = false;          ///< describe the settings instead of running
  std::string usage = {};     ///< with help: the flags that every problem has
  bool print_config = false;  ///< print the settings as they would be, instead of running
  bool print_schema = false;  ///< print what a file of settings may hold, likewise
};

/// Parses what follows the word `run`. Throws InputError if the problem is missing (unless help is
/// asked for), a second one is named, --config or --out occur twice, or a value is missing.
RunRequest parse_run_request(std::span<const std::string> arguments);

}  // namespace saltus
