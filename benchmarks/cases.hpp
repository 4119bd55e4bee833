// The timed problems, and the compared times.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "benchmarks/measurement.hpp"

namespace saltus::bench {

/// Selects the cases whose name contains `only`, with at least `solves` solves each.
struct Selection {
  int solves = 1000;
  std::string only = {};

  bool wants(const std::string& name) const { return name.find(only) != std::string::npos; }
};

/// Cases on the same instances. They are solved alternately, so that their times can be compared on
/// a machine with other load.
struct CaseGroup {
  std::vector<std::string> names;
  std::function<std::vector<CaseResult>(const Selection&)> run;  ///< runs the selected cases
};

std::vector<CaseGroup> step_recovery_cases();
std::vector<CaseGroup> sequence_cases();  // throws InputError if the recorded problems are missing
std::vector<CaseGroup> box_cases();
std::vector<CaseGroup> chain_cases();  // likewise
std::vector<CaseGroup> latency_cases();

/// scale x median of one case / median of another.
struct Comparison {
  std::string name, numerator, denominator;
  double scale = 1.0;
  double limit = 0.0;  ///< goal
};
std::vector<Comparison> comparisons();

}  // namespace saltus::bench
