// The command line of `saltus bench latency`.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "benchmarks/latency.hpp"
#include "benchmarks/latency_output.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/output_folder.hpp"
#include "saltus/core/error.hpp"

namespace saltus::bench {
namespace {

constexpr int quick_solves = 100;
constexpr const char* summary = "times of the structured solver";
constexpr const char* usage = "bench latency [--quick] [--json FILE] [--only PATTERN]";

ExitStatus run_latency(std::span<const std::string> arguments) {
  const LatencyRequest request = parse_latency_request(arguments);
  if (!request.help.empty()) {
    fmt::print("{}", request.help);
    return ExitStatus::ok;
  }
  std::optional<OutputFolder> folder;
  if (request.json) folder = folder_of_file("--json", *request.json);
  bool begun = false;  // no head above a sentence that nothing was measured
  const LatencyReport report = measure_latency(request.selection, [&](const CaseResult& result) {
    fmt::print("{}{}", begun ? "" : table_head(), table_line(result));
    begun = true;
    std::fflush(stdout);
  });
  fmt::print("{}", closing_text(report));
  if (folder) folder->write(request.json->filename().string(), to_json(report));
  return report.failures() == 0 ? ExitStatus::ok : ExitStatus::solver_failed;
}

}  // namespace

LatencyRequest parse_latency_request(std::span<const std::string> arguments) {
  LatencyRequest request;
  bool quick = false;
  OptionParser parser("bench latency", summary);
  parser.flag("--quick", "fewer solves: seconds in place of minutes", quick)
      .option("--json", "FILE", "all figures",
              [&](const std::string& file) { request.json = file; })
      .option("--only", "PATTERN", "part of the name of a case", request.selection.only);
  parser.parse(arguments);
  if (quick) request.selection.solves = quick_solves;
  if (parser.help_wanted()) request.help = parser.help();
  return request;
}

Verb verb() {
  return {"bench", usage, [](std::span<const std::string> arguments) {
            if (arguments.empty()) throw InputError(fmt::format("bench what? usage: {}", usage));
            if (arguments.front() != "latency")
              throw InputError(
                  fmt::format("unknown benchmark '{}'; usage: {}", arguments.front(), usage));
            return run_latency(arguments.subspan(1));
          }};
}

}  // namespace saltus::bench
