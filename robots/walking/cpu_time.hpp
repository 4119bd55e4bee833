// Adds the CPU time of its life to a sum.
#pragma once

#include "saltus/core/clock.hpp"

namespace saltus::walking {

class CpuTime {
 public:
  explicit CpuTime(double& seconds) : seconds_(seconds) {}
  ~CpuTime() { seconds_ += 1e-6 * (thread_microseconds() - begin_); }
  CpuTime(const CpuTime&) = delete;
  CpuTime& operator=(const CpuTime&) = delete;

 private:
  double& seconds_;
  double begin_ = thread_microseconds();
};

}  // namespace saltus::walking
