// Times between samples of a device that is simulated in steps.
#pragma once

#include <algorithm>
#include <cmath>

namespace saltus::robots {

/// Steps (of `step` s) between two samples at `rate` (Hz), at least one.
inline long steps_between(double rate, double step) {
  return std::max(1L, std::lround(1.0 / (rate * step)));
}
/// Time between two samples, a multiple of `step`, s.
inline double sample_period(double rate, double step) {
  return static_cast<double>(steps_between(rate, step)) * step;
}

}  // namespace saltus::robots
