// Histogram of durations in fixed logarithmic buckets. Counting takes a few nanoseconds and does
// not allocate; quantiles are accurate to the width of a bucket.
#pragma once

#include <array>
#include <cstdint>

namespace saltus {

/// There are eight buckets per factor of two, from 2^-24 s (60 ns) to 2^6 s; durations outside go
/// to the outermost buckets. A quantile is the upper end of its bucket, at most 12.5 % too large.
class LatencyHistogram {
 public:
  /// Adds one duration in seconds.
  void add(double seconds);
  /// Adds all entries of the other histogram.
  void merge(const LatencyHistogram& other);

  /// Number of entries.
  long count() const { return count_; }
  /// Smallest bucket end in seconds that `fraction` of all entries do not exceed; at most max().
  double quantile(double fraction) const;
  /// Median in seconds.
  double median() const { return quantile(0.5); }
  /// 99th percentile in seconds.
  double p99() const { return quantile(0.99); }
  /// 99.9th percentile in seconds.
  double p999() const { return quantile(0.999); }
  /// Largest duration in seconds.
  double max() const { return max_; }

 private:
  static constexpr int steps = 8, lowest = -24, highest = 6;
  static int bucket(double seconds);
  std::array<std::uint32_t, (highest - lowest) * steps> counts_{};
  long count_ = 0;
  double max_ = 0.0;
};

}  // namespace saltus
