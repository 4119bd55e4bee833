// A run in closed loop, and what is known of it afterwards.
#pragma once

#include <string>
#include <vector>

#include "problems/quadruped/config.hpp"
#include "saltus/simulation/closed_loop.hpp"

namespace saltus::quadruped {

/// What the robot did, at a tick.
struct Row {
  double time = 0.0;                ///< s
  PerLeg<double> feet, forces;      ///< m, N
  Touching touching{}, planned{};   ///< truly on the ground; by the schedule
  double tilt = 0.0, height = 0.0;  ///< rad; m above the ground
};

struct RunLog {
  LoopLog log;
  std::vector<Row> rows;
  bool fell = false;
  int early = 0, late = 0;  ///< landings that the schedule was edited for
  double waited = 0.0;      ///< of the gait, s
  double farthest = 0.0;    ///< turned over, rad
  const std::string& message() const { return log.message; }
};

/// The body of the robot turns over by more than this (rad), or is lower (m): it has fallen.
inline constexpr double fallen_tilt = 1.0, fallen_height = 0.12;

/// Ends early where an interrupt is noted (saltus/app/note_signals.hpp).
RunLog run(const Config& config);

/// Run number `i` of a campaign: ground, push and its time by chance; the size by the settings.
Config disturbed(const Config& config, int i, bool blind);

}  // namespace saltus::quadruped
