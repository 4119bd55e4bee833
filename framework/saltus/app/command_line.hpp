// Command line of `saltus run`.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "saltus/app/assignment.hpp"

namespace saltus {

/// Parsed form of `saltus run PROBLEM [--config FILE] [--set KEY=VALUE]... [--out DIR] [--KEY
/// VALUE]... [--quiet] [--json] [--print-config] [--print-schema]`. Any other flag names a setting:
/// `--KEY VALUE`, `--KEY=VALUE` and `--set KEY=VALUE` are equivalent, and `--KEY` alone sets a
/// boolean setting to true. `Settings` checks whether the problem has such a setting.
struct RunRequest {
  std::string problem;                               ///< name or alias of the problem
  std::optional<std::filesystem::path> config_file;  ///< value of --config
  std::vector<Assignment> assignments;  ///< settings of --set and other flags, in order
  std::filesystem::path out;            ///< results/PROBLEM unless --out is given
  bool quiet = false;                   ///< print only errors
  bool json = false;                    ///< print the summary as JSON instead of text
  bool help = false;                    ///< describe the settings instead of running
  std::string usage = {};     ///< usage text with the flags that every problem supports, set with
                              ///< --help
  bool print_config = false;  ///< print the resulting settings instead of running
  bool print_schema = false;  ///< print the JSON schema of the settings instead of running
};

/// Parses the arguments after the word `run`. Throws InputError if the problem is missing (unless
/// help is requested), a second one is given, --config or --out is repeated, or a value is missing.
RunRequest parse_run_request(std::span<const std::string> arguments);

}  // namespace saltus
