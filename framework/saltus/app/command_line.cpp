#include "saltus/app/program.hpp"

#include "saltus/app/option_parser.hpp"
#include "saltus/core/error.hpp"

namespace saltus {

RunRequest parse_run_request(std::span<const std::string> arguments) {
  RunRequest request;
  OptionParser parser("run", "Runs a problem and writes its results to a folder.");
  parser.word("problem", "name of the problem; 'saltus list' shows them", request.problem)
      .option("--config", "FILE", "settings as YAML",
              [&](const std::string& file) { request.config_file = file; })
      .option("--out", "DIR", "folder of the results; default results/PROBLEM",
              [&](const std::string& folder) { request.out = folder; })
      .repeated(
          "--set", "KEY=VALUE", "one setting; --KEY VALUE means the same",
          [&](const std::string& text) { request.assignments.push_back(parse_set_argument(text)); })
      .flag("--quiet", "print only errors", request.quiet)
      .flag("--json", "print summary.json instead of text", request.json)
      .flag("--print-config", "print all settings as documented YAML instead of running",
            request.print_config)
      .flag("--print-schema", "print a JSON Schema of the --config file instead of running",
            request.print_schema)
      .others([&](const std::string& flag, const std::optional<std::string>& value) {
        request.assignments.push_back(value ? flag_assignment(flag, *value)
                                            : bare_flag_assignment(flag));
      });
  parser.parse(arguments);
  request.help = parser.help_wanted();
  if (request.problem.empty() && !request.help) {
    throw InputError("run needs the name of a problem; 'saltus list' shows them");
  }
  if (request.help) request.usage = parser.help();
  if (request.out.empty()) request.out = std::filesystem::path("results") / request.problem;
  return request;
}

}  // namespace saltus
