// What a solve costs, whoever else runs on the machine: CPU time of the calling thread.
#pragma once

#include <ctime>
#include <stdexcept>

namespace saltus {

inline double thread_microseconds() {
  timespec now{};
  if (::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0)
    throw std::runtime_error("this system has no clock of a thread's CPU time");
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace saltus
