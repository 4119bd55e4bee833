// The command line of `saltus bench latency`.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "benchmarks/against.hpp"
#include "benchmarks/latency.hpp"
#include "benchmarks/latency_output.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/program.hpp"
#include "saltus/core/error.hpp"

namespace saltus::bench {
namespace {

constexpr int quick_solves = 100;
constexpr const char* summary = "measures the solve times of the structured solver";
constexpr const char* usage =
    "bench latency [--quick] [--json FILE] [--only PATTERN] [--against hpipm]";

ExitStatus run_against_hpipm(const LatencyRequest& request) {
  const std::filesystem::path library = hpipm_library(request.library);
  fmt::print("HPIPM is {}\n\n{}", library.string(), duel_head());
  bool failed = false;
  measure_against_hpipm(library, request.selection, [&](const Duel& duel) {
    fmt::print("{}", duel_line(duel));
    std::fflush(stdout);
    failed = failed || !duel.ours.failures.empty();
  });
  fmt::print(
      "\nratio: our time divided by HPIPM's, median over the instances; each time is the minimum "
      "of five alternating solves.\nOur time includes reading the program, HPIPM's does not.\n");
  return failed ? ExitStatus::solver_failed : ExitStatus::ok;
}

ExitStatus run_latency(std::span<const std::string> arguments) {
  const LatencyRequest request = parse_latency_request(arguments);
  if (!request.help.empty()) {
    fmt::print("{}", request.help);
    return ExitStatus::ok;
  }
  if (request.against_hpipm) return run_against_hpipm(request);
  std::optional<OutputFolder> folder;
  if (request.json) folder = folder_of_file("--json", *request.json);
  bool begun = false;  // no table head above an error message
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
  parser.flag("--quick", "fewer solves: seconds instead of minutes", quick)
      .option("--json", "FILE", "file for all figures",
              [&](const std::string& file) { request.json = file; })
      .option("--only", "PATTERN", "part of the name of a case", request.selection.only)
      .option("--against", "SOLVER", "alternate with another solver: hpipm",
              [&](const std::string& solver) {
                if (solver != "hpipm")
                  throw InputError(fmt::format("--against supports hpipm, not '{}'", solver));
                request.against_hpipm = true;
              })
      .option("--library", "FILE", "shared library of the solver of --against",
              [&](const std::string& file) { request.library = file; });
  parser.parse(arguments);
  if (request.library && !request.against_hpipm)
    throw InputError("--library needs --against hpipm");
  if (request.json && request.against_hpipm)
    throw InputError("--json is not available with --against");
  if (quick) request.selection.solves = quick_solves;
  if (parser.help_wanted()) request.help = parser.help();
  return request;
}

Verb verb() {
  return {"bench", usage, [](std::span<const std::string> arguments) {
            if (arguments.empty())
              throw InputError(fmt::format("bench needs a command; usage: {}", usage));
            if (arguments.front() != "latency")
              throw InputError(
                  fmt::format("unknown benchmark '{}'; usage: {}", arguments.front(), usage));
            return run_latency(arguments.subspan(1));
          }};
}

}  // namespace saltus::bench
