// The command line of `saltus suite`.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "problems/suite/suite.hpp"
#include "problems/suite/suite_output.hpp"
#include "saltus/app/argument_reader.hpp"
#include "saltus/app/output_folder.hpp"
#include "saltus/app/settings.hpp"

namespace saltus {
namespace {

constexpr const char* usage =
    "suite [--only PATTERN] [--set solver=ipopt|riccati|sparse] [--json FILE]";

ExitStatus run(std::span<const SuiteCase> cases, std::span<const std::string> arguments) {
  const SuiteRequest request = parse_suite_request(arguments);
  std::optional<OutputFolder> folder;
  if (request.json) folder = folder_of_file("--json", *request.json);
  bool begun = false;  // no head above a sentence that there is no such case
  const SuiteReport report = run_suite(cases, request, [&](const CaseOutcome& outcome) {
    fmt::print("{}{}", std::exchange(begun, true) ? "" : table_head(), table_line(outcome));
    std::fflush(stdout);
  });
  fmt::print("{}", closing_text(report));
  if (folder) folder->write(request.json->filename().string(), to_json(report));
  return report.exit_status();
}

}  // namespace

SuiteRequest parse_suite_request(std::span<const std::string> arguments) {
  SuiteRequest request;
  std::vector<Assignment> assignments;
  ArgumentReader reader(arguments);
  while (!reader.at_end()) {
    const std::string flag = reader.next();
    if (flag == "--only") {
      reader.once();
      request.only = reader.require_value("PATTERN");
    } else if (flag == "--json") {
      reader.once();
      request.json = reader.require_value("FILE");
    } else if (flag == "--set") {
      assignments.push_back(parse_set_argument(reader.require_value("KEY=VALUE")));
    } else {
      reader.reject({"--only", "--set", "--json"}, usage);
    }
  }
  Settings settings;
  settings.choice("solver", request.solver, solver_choices(),
                  "what solves the optimisation problems");
  settings.apply(assignments);
  return request;
}

Verb suite_verb(std::function<std::vector<SuiteCase>()> cases) {
  return {"suite", usage, [cases = std::move(cases)](std::span<const std::string> arguments) {
            const std::vector<SuiteCase> all = cases();
            return run(all, arguments);
          }};
}

}  // namespace saltus
