// Measurement of processor time in a scope.
#pragma once

#include "saltus/core/clock.hpp"

namespace saltus::robots::walking {

/// Adds the processor time of its scope to a number.
class CpuTime {
 public:
  /// Adds to `seconds`, in s, which must outlive this object.
  explicit CpuTime(double& seconds) : seconds_(seconds) {}
  ~CpuTime() { seconds_ += 1e-6 * (thread_microseconds() - begin_); }
  CpuTime(const CpuTime&) = delete;
  CpuTime& operator=(const CpuTime&) = delete;

 private:
  double& seconds_;
  double begin_ = thread_microseconds();
};

}  // namespace saltus::robots::walking
