// What a closed loop tells of itself while it runs, and one line of text for it.
#pragma once

#include <cstdio>
#include <functional>
#include <string>

#include "saltus/core/clock.hpp"

namespace saltus::walking {

/// What the robot is doing, for a line of progress.
enum class Footing { standing, pushed, stepping, landed };

/// In words.
const char* describe(Footing footing);

/// The loop at one tick of the planner.
struct LoopState {
  double time = 0.0;        ///< s
  double com_height = 0.0;  ///< m
  /// Of the capture point from the edge of what the robot stands on, m: positive inside. Until the
  /// landing that is the stance sole, after it the hull of both.
  double margin = 0.0;
  Footing footing = Footing::standing;  ///< what the robot is doing
};

/// Called at every tick of the planner; false ends the run, whose results up to then are kept.
using Observer = std::function<bool(const LoopState&)>;

/// "t =  3.10 s | 1.4 x real time | CoM 0.534 m | capture point  21 mm inside | landed".
std::string progress_line(const LoopState& state, double wall_clock);

/// Shows the line of a run: on a terminal one that is written over, elsewhere one per simulated
/// second. What is shown before `finish` may lie up to 50 ms back.
class Progress {
 public:
  /// On a terminal one line is rewritten.
  Progress(std::FILE* out, bool terminal) : out_(out), terminal_(terminal) {}

  /// Writes when there is something new to say.
  void show(const LoopState& state);
  /// The last state that was given, and the end of the line.
  void finish();

 private:
  void print(double now);

  std::FILE* out_;
  bool terminal_;
  WallClock::time_point begin_ = WallClock::now();
  LoopState state_;
  double next_ = 0.0;  // when to print again: wall clock on a terminal, else simulated, s
  bool shown_ = true;  // the last state that was given
};

}  // namespace saltus::walking
