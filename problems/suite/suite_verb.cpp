// The command line of `saltus suite`.
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "problems/suite/suite.hpp"
#include "problems/suite/suite_output.hpp"
#include "saltus/app/defer_signals.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/settings.hpp"

namespace saltus {
namespace {

constexpr const char* summary =
    "compares every problem of the library with its known answer, in one table";

ExitStatus run(std::span<const SuiteCase> cases, std::span<const std::string> arguments) {
  SuiteRequest request = parse_suite_request(arguments);
  if (!request.help.empty()) {
    fmt::print("{}", request.help);
    return ExitStatus::ok;
  }
  std::optional<OutputFolder> folder;
  if (request.json) folder = folder_of_file("--json", *request.json);
  bool begun = false;  // no table head above an error message
  int signal = 0;
  request.should_stop = [] { return DeferSignals::received() != 0; };
  const SuiteReport report = [&] {
    const DeferSignals note;
    SuiteReport result = run_suite(cases, request, [&](const CaseOutcome& outcome) {
      if (request.quiet) return;
      fmt::print("{}{}", std::exchange(begun, true) ? "" : table_head(), table_line(outcome));
      std::fflush(stdout);
    });
    signal = DeferSignals::received();
    return result;
  }();
  if (!request.quiet) fmt::print("{}", closing_text(report));
  if (folder) folder->write(request.json->filename().string(), to_json(report));
  if (signal != 0) {
    if (!request.quiet) fmt::print("interrupted: results of {} cases\n", report.outcomes.size());
    std::fflush(nullptr);
    std::raise(signal);
  }
  return report.exit_status();
}

}  // namespace

SuiteRequest parse_suite_request(std::span<const std::string> arguments) {
  SuiteRequest request;
  std::vector<Assignment> assignments;
  OptionParser parser("suite", summary);
  parser.option("--only", "PATTERN", "part of an id or name, case-insensitive", request.only)
      .repeated("--set", "KEY=VALUE", "solver=ipopt|riccati|sparse",
                [&](const std::string& text) { assignments.push_back(parse_set_argument(text)); })
      .option("--json", "FILE", "all compared values, with all digits",
              [&](const std::string& file) { request.json = file; })
      .flag("--quiet", "print only errors; the result is in FILE and the exit status",
            request.quiet);
  parser.parse(arguments);
  if (parser.help_wanted()) request.help = parser.help();
  Settings settings;
  settings.choice("solver", request.solver, solver_choices(),
                  "solver of the optimisation problems");
  settings.apply(assignments);
  return request;
}

Verb suite_verb(std::function<std::vector<SuiteCase>()> cases) {
  return {"suite", summary, [cases = std::move(cases)](std::span<const std::string> arguments) {
            const std::vector<SuiteCase> all = cases();
            return run(all, arguments);
          }};
}

}  // namespace saltus
