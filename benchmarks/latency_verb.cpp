// The command line of `saltus bench latency`.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "benchmarks/latency.hpp"
#include "benchmarks/latency_output.hpp"
#include "framework/app/output_folder.hpp"
#include "framework/core/error.hpp"
#include "framework/core/text.hpp"

namespace saltus::bench {
namespace {

constexpr int quick_solves = 100;
constexpr const char* usage = "bench latency [--quick] [--json FILE] [--only PATTERN]";

// Proved writable before minutes are spent on measuring.
OutputFolder folder_of(const std::filesystem::path& file) {
  std::error_code error;
  if (!file.has_filename() || std::filesystem::is_directory(file, error))
    throw InputError(fmt::format("--json needs a file, but '{}' is a folder", file.string()));
  return OutputFolder(file.has_parent_path() ? file.parent_path() : ".");
}

ExitStatus run_latency(std::span<const std::string> arguments) {
  const LatencyRequest request = parse_latency_request(arguments);
  std::optional<OutputFolder> folder;
  if (request.json) folder = folder_of(*request.json);
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
  bool quick = false, only = false;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::size_t equals =
        arguments[i].starts_with("--") ? arguments[i].find('=') : std::string::npos;
    const std::string flag = arguments[i].substr(0, equals);
    const auto once = [&](bool before) {
      if (before) throw InputError(fmt::format("{} is given twice", flag));
    };
    const auto value = [&]() -> std::string {
      const bool joined = equals != std::string::npos;
      if (!joined && (i + 1 == arguments.size() || arguments[i + 1].starts_with("--")))
        throw InputError(fmt::format("{} needs a value", flag));
      const std::string text = joined ? arguments[i].substr(equals + 1) : arguments[++i];
      if (text.empty()) throw InputError(fmt::format("{} needs a value", flag));
      return text;
    };
    if (flag == "--quick" && equals == std::string::npos) {
      once(quick);
      quick = true;
      request.selection.solves = quick_solves;
    } else if (flag == "--json") {
      once(request.json.has_value());
      request.json = value();
    } else if (flag == "--only") {
      once(only);
      only = true;
      request.selection.only = value();
    } else {
      const std::string meant = nearest_name(flag, {"--quick", "--json", "--only"});
      throw InputError(meant.empty() || meant == flag
                           ? fmt::format("'{}' is not understood; usage: {}", arguments[i], usage)
                           : fmt::format("unknown flag '{}'; did you mean '{}'?", flag, meant));
    }
  }
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
