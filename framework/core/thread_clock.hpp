// What a solve costs, whoever else runs on the machine: CPU time of the calling thread.
#pragma once

#include <ctime>

namespace saltus {

/// Since the thread began; 0 where there is no such clock (POSIX makes it optional).
inline double thread_microseconds() noexcept {
  timespec now{};
  if (::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0) return 0.0;
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace saltus
