#include "benchmarks/statistics.hpp"

#include <algorithm>

namespace saltus::bench {

Spread spread(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const std::size_t n = samples.size();
  return {.median = 0.5 * (samples[(n - 1) / 2] + samples[n / 2]),
          .p99 = samples[(99 * n + 99) / 100 - 1],
          .max = samples.back()};
}

}  // namespace saltus::bench
