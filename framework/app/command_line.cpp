#include "framework/app/command_line.hpp"

#include <fmt/format.h>

#include "framework/core/error.hpp"

namespace saltus {
namespace {

// Reads the arguments one after the other; a value follows its flag as "--flag=value" or as the
// next argument.
class ArgumentReader {
 public:
  explicit ArgumentReader(std::span<const std::string> arguments) : rest_(arguments) {}

  bool at_end() const { return rest_.empty(); }

  /// The next argument; if it is "--flag=value", the value is kept for take_value().
  std::string next() {
    std::string argument = rest_.front();
    rest_ = rest_.subspan(1);
    value_.reset();
    const auto equals = argument.find('=');
    if (argument.starts_with("--") && equals != std::string::npos) {
      value_ = argument.substr(equals + 1);
      argument.resize(equals);
    }
    return argument;
  }

  std::optional<std::string> take_value() {
    if (!value_ && !rest_.empty() && !rest_.front().starts_with("--")) {
      value_ = rest_.front();
      rest_ = rest_.subspan(1);
    }
    return std::move(value_);
  }

  std::string require_value(const std::string& flag, std::string_view what) {
    std::optional<std::string> value = take_value();
    if (!value || value->empty()) {
      throw InputError(fmt::format("{} needs a value: {} {}", flag, flag, what));
    }
    return *value;
  }

 private:
  std::span<const std::string> rest_;
  std::optional<std::string> value_;
};

}  // namespace

RunRequest parse_run_request(std::span<const std::string> arguments) {
  RunRequest request;
  ArgumentReader reader(arguments);
  const auto once = [](bool already_given, const std::string& flag) {
    if (already_given) throw InputError(fmt::format("{} is given twice", flag));
  };
  while (!reader.at_end()) {
    const std::string argument = reader.next();
    if (argument == "--help" || argument == "-h") {
      request.help = true;
    } else if (argument == "--config") {
      once(request.config_file.has_value(), argument);
      request.config_file = reader.require_value(argument, "FILE");
    } else if (argument == "--out") {
      once(!request.out.empty(), argument);
      request.out = reader.require_value(argument, "DIR");
    } else if (argument == "--set") {
      request.assignments.push_back(
          parse_set_argument(reader.require_value(argument, "KEY=VALUE")));
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
