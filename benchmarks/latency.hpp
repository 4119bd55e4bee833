// `saltus bench latency`: measures the structured solvers on this machine.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/cases.hpp"
#include "saltus/app/program.hpp"

namespace saltus::bench {

struct LatencyReport {
  double calibration_us = 0.0;
  std::vector<CaseResult> cases;
  std::vector<Comparison> comparisons;  ///< comparisons whose cases were timed

  const CaseResult* find(const std::string& name) const;
  double ratio(const Comparison& comparison) const;
  int failures() const;
};

/// Runs the selected cases and calls `observe` after each one. Throws InputError if there is none,
/// or if a file of recorded problems is missing.
LatencyReport measure_latency(const Selection& selection,
                              const std::function<void(const CaseResult&)>& observe = {});

struct LatencyRequest {
  Selection selection;
  std::optional<std::filesystem::path> json = {};
  bool against_hpipm = false;
  std::optional<std::filesystem::path> library = {};  ///< path of HPIPM
  std::string help = {};  ///< not empty: help was requested instead of a run
};
/// Parses the arguments after `bench latency`. Throws InputError.
LatencyRequest parse_latency_request(std::span<const std::string> arguments);

/// The verb `bench`.
Verb verb();

}  // namespace saltus::bench
