// How long things took, counted in fixed logarithmic buckets: counting costs a few nanoseconds and
// no memory, and quantiles are good to the width of a bucket.
#pragma once

#include <array>
#include <cstdint>

namespace saltus {

/// Eight buckets per factor of two, from 2^-24 s (60 ns) to 2^6 s; what lies beyond goes to the
/// outermost ones. A quantile is the upper end of its bucket, at most 12.5 % too large.
class LatencyHistogram {
 public:
  /// Counts one.
  void add(double seconds);
  /// Counts all of the other's.
  void merge(const LatencyHistogram& other);

  /// How many were counted.
  long count() const { return count_; }
  /// Smallest bucket end that `fraction` of all entries do not exceed; never above max(). s.
  double quantile(double fraction) const;
  /// Half of them took no longer, s.
  double median() const { return quantile(0.5); }
  /// 99 of 100 took no longer, s.
  double p99() const { return quantile(0.99); }
  /// 999 of 1000 took no longer, s.
  double p999() const { return quantile(0.999); }
  /// The longest, s.
  double max() const { return max_; }

 private:
  static constexpr int steps = 8, lowest = -24, highest = 6;
  static int bucket(double seconds);
  std::array<std::uint32_t, (highest - lowest) * steps> counts_{};
  long count_ = 0;
  double max_ = 0.0;
};

}  // namespace saltus
