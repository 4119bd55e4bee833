// Clocks: wall-clock time for deadlines, CPU time for measurements.
#pragma once

#include <chrono>
#include <cmath>
#include <ctime>

namespace saltus {

/// A monotonic clock.
using WallClock = std::chrono::steady_clock;

/// Wall-clock seconds since `begin`.
inline double seconds_since(WallClock::time_point begin) noexcept {
  return std::chrono::duration<double>(WallClock::now() - begin).count();
}

/// The instant `seconds` after `begin`, or time_point::max() if `seconds` is not finite.
inline WallClock::time_point seconds_after(WallClock::time_point begin, double seconds) noexcept {
  if (!std::isfinite(seconds)) return WallClock::time_point::max();
  return begin +
         std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(seconds));
}

/// CPU time of the calling thread in microseconds. Other load on the machine does not count.
/// Returns 0 on systems without such a clock, which POSIX makes optional.
inline double thread_microseconds() noexcept {
  timespec now{};
  if (::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0) return 0.0;
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace saltus
