// A pendulum with a flywheel that follows a step planner: the plant for comparisons of planners
// alone.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "problems/push_recovery/step_choice.hpp"

namespace saltus::push_recovery {

/// A horizontal push of constant force, world axes.
struct PendulumPush {
  double start = 0.2, duration = 0.1;               // s
  Vec<double, 2> impulse = Vec<double, 2>::Zero();  // N s
};

struct WalkerOptions {
  double mass = 33.06, height = 0.5579;  // kg, m
  SoleCentres centres{{0.0265, 0.005}, {0.0265, -0.005}};
  Vec<double, 2> half_sole{0.08, 0.036};  // m
  double lent = 0.0, lent_rate = 0.0;     // bounds on eta, m, and its rate, m/s
  double apart = 0.14;                    // initial distance of the soles' origins, m
  bool left_stands = true, right_stands = false;
  double period = 0.01, duration = 4.0;  // s
};

struct WalkerRun {
  bool recovered = false;
  int steps = 0;
  double first_landing = infinity;  ///< since the start of the push, s
  double foot_speed = 0.0;          ///< largest speed, m/s
  std::vector<double> seconds;      ///< processor time of each tick
  std::vector<int> iterations;      ///< quadratic programs of each tick
};

/// Applies the planner's first input to the pendulum, within the limits of the true soles. A run
/// counts as recovered if at the end the capture point is at rest within the standing soles.
WalkerRun walk(StepChoice& planner, const WalkerOptions& options,
               std::span<const PendulumPush> pushes,
               const std::function<void(const StepSituation&, const StepPlan&)>& observe = {});

}  // namespace saltus::push_recovery
