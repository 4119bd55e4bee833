#include "saltus/app/command_line.hpp"

#include <fmt/format.h>

#include "saltus/app/argument_reader.hpp"
#include "saltus/core/error.hpp"

namespace saltus {

RunRequest parse_run_request(std::span<const std::string> arguments) {
  RunRequest request;
  ArgumentReader reader(arguments);
  while (!reader.at_end()) {
    const std::string argument = reader.next();
    if (argument == "--help" || argument == "-h") {
      request.help = true;
    } else if (argument == "--config") {
      reader.once();
      request.config_file = reader.require_value("FILE");
    } else if (argument == "--out") {
      reader.once();
      request.out = reader.require_value("DIR");
    } else if (argument == "--set") {
      request.assignments.push_back(parse_set_argument(reader.require_value("KEY=VALUE")));
    } else if (argument.starts_with("--") && argument.size() > 2) {
      const std::string flag = argument.substr(2);
      const std::optional<std::string> value = reader.take_value();
      request.assignments.push_back(value ? flag_assignment(flag, *value)
                                          : bare_flag_assignment(flag));
    } else if (argument.starts_with("-")) {
      throw InputError(fmt::format("unknown flag '{}'; flags begin with two dashes", argument));
    } else if (request.problem.empty()) {
      request.problem = argument;
    } else {
      throw InputError(
          fmt::format("one problem at a time: '{}' or '{}'?", request.problem, argument));
    }
  }
  if (request.problem.empty() && !request.help) {
    throw InputError("run needs the name of a problem; 'saltus list' shows them");
  }
  if (request.out.empty()) request.out = std::filesystem::path("results") / request.problem;
  return request;
}

}  // namespace saltus
