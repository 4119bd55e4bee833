#include "benchmarks/cases.hpp"

#include <iterator>

namespace saltus::bench {

std::vector<CaseGroup> latency_cases() {
  std::vector<CaseGroup> all;
  for (const auto& some : {step_recovery_cases, sequence_cases, box_cases, chain_cases}) {
    std::vector<CaseGroup> groups = some();
    std::move(groups.begin(), groups.end(), std::back_inserter(all));
  }
  return all;
}

std::vector<Comparison> comparisons() {
  const std::string any = ",run-time-sizes";
  std::vector<Comparison> list;
  for (const std::string name :
       {"recipe/kI=7", "box/4x1", "box/8x3", "box/12x4", "box/18x3", "box/24x12"})
    list.push_back({.name = "run-time sizes against fixed ones, " + name,
                    .numerator = name + any,
                    .denominator = name,
                    .limit = name == "box/4x1" ? 3.0 : 1.5});
  list.push_back({.name = "time per stage, N = 1500 against N = 15",
                  .numerator = "recipe/kI=0,N=1500",
                  .denominator = "recipe/kI=0",
                  .scale = 15.0 / 1500.0,
                  .limit = 1.5});
  return list;
}

}  // namespace saltus::bench
