// Time as it passes and time as it is worked: wall clock for deadlines, CPU time for costs.
#pragma once

#include <chrono>
#include <cmath>
#include <ctime>

namespace saltus {

/// Never set back.
using WallClock = std::chrono::steady_clock;

/// Seconds that have passed since.
inline double seconds_since(WallClock::time_point begin) noexcept {
  return std::chrono::duration<double>(WallClock::now() - begin).count();
}

/// The instant so many seconds after `begin`; never, time_point::max(), if they are infinite.
inline WallClock::time_point seconds_after(WallClock::time_point begin, double seconds) noexcept {
  if (!std::isfinite(seconds)) return WallClock::time_point::max();
  return begin +
         std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(seconds));
}

/// CPU time of the calling thread since it began, whoever else runs on the machine; 0 where there
/// is no such clock (POSIX makes it optional).
inline double thread_microseconds() noexcept {
  timespec now{};
  if (::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0) return 0.0;
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace saltus
