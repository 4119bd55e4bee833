// A run in closed loop and its results.
#pragma once

#include <string>
#include <vector>

#include "problems/quadruped/config.hpp"
#include "saltus/simulation/closed_loop.hpp"

namespace saltus::quadruped {

/// State of the robot at a tick.
struct Row {
  double time = 0.0;                ///< s
  PerLeg<double> feet, forces;      ///< m, N
  Touching touching{}, planned{};   ///< true contacts; contacts of the schedule
  double tilt = 0.0, height = 0.0;  ///< rad; m above the ground
};

struct RunLog {
  LoopLog log;
  std::vector<Row> rows;
  bool fell = false;
  int early = 0, late = 0;  ///< landings that edited the schedule
  double waited = 0.0;      ///< total waiting time of the gait, s
  double farthest = 0.0;    ///< largest tilt, rad
  const std::string& message() const { return log.message; }
};

/// The robot has fallen if it tilts by more (rad) or its CoM is lower (m).
inline constexpr double fallen_tilt = 1.0, fallen_height = 0.12;

/// Ends early after an interrupt (saltus/app/defer_signals.hpp).
RunLog run(const Config& config);

/// Run number `i` of a campaign: random ground, push and time; the settings define their sizes.
Config disturbed(const Config& config, int i, bool blind);

}  // namespace saltus::quadruped
