#include "benchmarks/latency_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "saltus/qp/lanes.hpp"

namespace saltus::bench {
namespace {

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string compiler() {
#if defined(__clang__)
  return "clang " __clang_version__;
#else
  return "gcc " __VERSION__;
#endif
}

double relative(const CaseResult& result, const LatencyReport& report) {
  return result.microseconds.median / report.calibration_us;
}

}  // namespace

std::string table_head() {
  return fmt::format("{:<28} {:>5} {:>10} {:>10} {:>10} {:>6} {:>4} {:>8} {:>6}\n", "case", "n",
                     "median us", "p99 us", "max us", "it", "max", "KKT", "failed");
}

std::string table_line(const CaseResult& r) {
  return fmt::format("{:<28} {:>5} {:>10.1f} {:>10.1f} {:>10.1f} {:>6.2f} {:>4} {:>8.1e} {:>6}\n",
                     r.name, r.n, r.microseconds.median, r.microseconds.p99, r.microseconds.max,
                     r.iterations_mean, r.iterations_max, r.kkt_max, r.failures.size());
}

std::string closing_text(const LatencyReport& report) {
  std::string text = fmt::format(
      "\nThe calibration kernel took {:.2f} us; medians in units of this time, and other counts:\n",
      report.calibration_us);
  for (const CaseResult& r : report.cases) {
    text += fmt::format("{:<28} {:>10.2f}", r.name, relative(r, report));
    if (r.iterations_mean > 0.0)
      text += fmt::format("   {:.2f} us per iteration", r.microseconds.median / r.iterations_mean);
    for (const Detail& d : r.details) text += fmt::format("   {} {:.2f}", d.name, d.value);
    text += "\n";
  }
  if (!report.comparisons.empty()) text += "\nRatios of medians:\n";
  for (const Comparison& c : report.comparisons)
    text += fmt::format("{:<52} {:>6.2f}  (at most {})\n", c.name, report.ratio(c), c.limit);
  for (const CaseResult& r : report.cases)
    for (const Failure& f : r.failures)
      text += fmt::format("\nFAILED {} seed {}: KKT residual {:.2e}, {}", r.name, f.seed,
                          f.residual, describe(f.status));
  if (report.failures() > 0) text += fmt::format("\n{} solves failed\n", report.failures());
  return text;
}

nlohmann::ordered_json to_json(const LatencyReport& report) {
  using Json = nlohmann::ordered_json;
  Json cases = Json::array();
  for (const CaseResult& r : report.cases) {
    Json details = Json::object(), failed = Json::array();
    for (const Detail& d : r.details) details[d.name] = d.value;
    for (const Failure& f : r.failures)
      failed.push_back({{"seed", f.seed}, {"status", describe(f.status)}, {"kkt", f.residual}});
    cases.push_back({{"name", r.name},
                     {"n", r.n},
                     {"median_us", r.microseconds.median},
                     {"p99_us", r.microseconds.p99},
                     {"max_us", r.microseconds.max},
                     {"iterations_mean", r.iterations_mean},
                     {"iterations_max", r.iterations_max},
                     {"kkt_max", r.kkt_max},
                     {"failures", r.failures.size()},
                     {"relative_to_calibration", relative(r, report)},
                     {"details", details},
                     {"failed", failed}});
  }
  Json ratios = Json::array();
  for (const Comparison& c : report.comparisons)
    ratios.push_back({{"name", c.name}, {"ratio", report.ratio(c)}, {"limit", c.limit}});
  return {{"machine", {{"cpu", processor()}, {"lanes", qp::lanes}}},
          {"build",
           {{"compiler", compiler()},
            {"march", SALTUS_BUILD_MARCH},
            {"type", SALTUS_BUILD_TYPE},
            {"version", SALTUS_VERSION}}},
          {"calibration_us", report.calibration_us},
          {"cases", cases},
          {"comparisons", ratios}};
}

}  // namespace saltus::bench
