// Progress of a closed loop while it runs, as one line of text.
#pragma once

#include <cstdio>
#include <string>

#include "saltus/core/clock.hpp"
#include "saltus/robots/walking/run_log.hpp"

namespace saltus::robots::walking {

/// Text for the progress line.
const char* describe(LoopState::Footing footing);

/// "t =  3.10 s | 1.4 x real time | CoM 0.534 m | capture point  21 mm inside | landed".
std::string progress_line(const LoopState& state, double wall_clock);

/// Shows the progress line of a run: on a terminal it is overwritten, elsewhere one line is printed
/// per simulated second. Before `finish` the line may be up to 50 ms old.
class Progress {
 public:
  /// With `terminal`, the line is overwritten.
  Progress(std::FILE* out, bool terminal) : out_(out), terminal_(terminal) {}

  /// Prints if the next update is due.
  void show(const LoopState& state);
  /// Prints the last state and ends the line.
  void finish();

 private:
  void print(double now);

  std::FILE* out_;
  bool terminal_;
  WallClock::time_point begin_ = WallClock::now();
  LoopState state_;
  double next_ = 0.0;  // next print: wall clock on a terminal, else simulated time, s
  bool shown_ = true;  // true if the last state was printed
};

}  // namespace saltus::robots::walking
