// Times of one call: the wall clock, and the processor time of all threads of this process.
#pragma once

#include <ctime>

#include "saltus/core/clock.hpp"

namespace saltus::bench {

/// Times in microseconds.
struct Times {
  double wall = 0.0;
  double cpu = 0.0;  ///< all threads of the process
};

inline double process_microseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

template <class Call>
Times timed(Call&& call) {
  const double cpu = process_microseconds();
  const auto begin = WallClock::now();
  call();
  const double wall = 1e6 * seconds_since(begin);
  return {wall, process_microseconds() - cpu};
}

/// Times of a set-up, of the first solve with new memory, and of a repeated solve.
struct SolveTimes {
  Times setup, first, repeated;
};

/// Solves above this time are not repeated: warm caches do not matter. The rule is the same for
/// other solvers.
inline constexpr double slow_microseconds = 1e5;

/// Calls `solve` once or twice.
template <class Solve>
void timed_twice(SolveTimes& times, Solve&& solve) {
  times.first = timed(solve);
  times.repeated = times.first.wall < slow_microseconds ? timed(solve) : times.first;
}

}  // namespace saltus::bench
