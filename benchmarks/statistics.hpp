// Statistics of times: median, 99th percentile, maximum.
#pragma once

#include <vector>

namespace saltus::bench {

struct Spread {
  double median = 0.0, p99 = 0.0, max = 0.0;
};
/// The 99th percentile is the smallest sample that at least 99 of 100 do not exceed. Zeros if
/// empty.
Spread spread(std::vector<double> samples);

}  // namespace saltus::bench
