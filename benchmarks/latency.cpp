#include "benchmarks/latency.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "benchmarks/calibration.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus::bench {

const CaseResult* LatencyReport::find(const std::string& name) const {
  const auto at =
      std::find_if(cases.begin(), cases.end(), [&](const CaseResult& c) { return c.name == name; });
  return at == cases.end() ? nullptr : &*at;
}

double LatencyReport::ratio(const Comparison& comparison) const {
  const CaseResult* above = find(comparison.numerator);
  const CaseResult* below = find(comparison.denominator);
  if (above == nullptr || below == nullptr) return NAN;
  return comparison.scale * above->microseconds.median / below->microseconds.median;
}

int LatencyReport::failures() const {
  std::size_t sum = 0;
  for (const CaseResult& c : cases) sum += c.failures.size();
  return static_cast<int>(sum);
}

LatencyReport measure_latency(const Selection& selection,
                              const std::function<void(const CaseResult&)>& observe) {
  std::vector<std::string> names;
  LatencyReport report;
  std::vector<double> calibrations;
  for (const CaseGroup& group : latency_cases()) {
    names.insert(names.end(), group.names.begin(), group.names.end());
    if (std::none_of(group.names.begin(), group.names.end(),
                     [&](const std::string& name) { return selection.wants(name); }))
      continue;
    // The clock of a processor varies, so the kernel is timed with every group.
    calibrations.push_back(calibrate());
    for (CaseResult& result : group.run(selection)) {
      if (observe) observe(result);
      report.cases.push_back(std::move(result));
    }
    calibrations.push_back(calibrate());
  }
  if (report.cases.empty()) {
    const std::string meant = nearest_name(selection.only, names);
    throw InputError(meant.empty() ? fmt::format("no case has '{}' in its name; the cases are {}",
                                                 selection.only, join_names(names))
                                   : fmt::format("no case has '{}' in its name; did you mean '{}'?",
                                                 selection.only, meant));
  }
  report.calibration_us = spread(std::move(calibrations)).median;
  for (const Comparison& comparison : comparisons())
    if (!std::isnan(report.ratio(comparison))) report.comparisons.push_back(comparison);
  return report;
}

}  // namespace saltus::bench
