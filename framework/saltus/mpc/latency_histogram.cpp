#include "saltus/mpc/receding_horizon.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace saltus {

// The bucket is the exponent of a double and the first bits of its mantissa.
int LatencyHistogram::bucket(double seconds) {
  if (!(seconds > 0.0)) return 0;
  constexpr int mantissa_bits = 52, kept_bits = 3, bias = 1023;
  static_assert(steps == 1 << kept_bits);
  const auto bits = std::bit_cast<std::uint64_t>(seconds) >> (mantissa_bits - kept_bits);
  const long index = static_cast<long>(bits) - (static_cast<long>(bias + lowest) << kept_bits);
  return static_cast<int>(std::clamp(index, 0L, static_cast<long>((highest - lowest) * steps - 1)));
}

void LatencyHistogram::add(double seconds) {
  ++counts_[bucket(seconds)];
  ++count_;
  max_ = std::max(max_, seconds);
}

void LatencyHistogram::merge(const LatencyHistogram& other) {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
  count_ += other.count_;
  max_ = std::max(max_, other.max_);
}

double LatencyHistogram::quantile(double fraction) const {
  const double wanted = fraction * static_cast<double>(count_);
  double sum = 0.0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    sum += counts_[i];
    if (counts_[i] == 0 || sum < wanted) continue;
    const int octave = static_cast<int>(i) / steps, step = static_cast<int>(i) % steps;
    const double end = std::ldexp(1.0 + (step + 1.0) / steps, lowest + octave);
    return std::min(end, max_);
  }
  return max_;
}

}  // namespace saltus
