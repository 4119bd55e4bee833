// From the measurement to the commands: gait, footholds, data of the plan, swing legs.
#pragma once

#include <array>

#include "problems/quadruped/gait.hpp"
#include "problems/quadruped/plant.hpp"
#include "problems/quadruped/problem.hpp"
#include "saltus/mpc/receding_horizon.hpp"

namespace saltus::quadruped {

struct ControllerSettings {
  Model model;
  Weights weights;
  GaitSettings gait;
  double period = 0.01;                // control period, s
  double height = 0.29;                // height of the CoM above the feet, m
  double speed = 0.4, sideways = 0.0;  // m/s, in the axes of the body
  double turn = 0.0;                   // rad/s
  double clearance = 0.08;             // clearance of a swing foot, m
  double landing_speed = 1.0;          // m/s, downwards; also the speed of a late foot
  double foothold_gain = 0.12;         // gain on the velocity error, s
  double longest_step = 0.22;          // largest distance of a foothold from below the hip, m
};

class Controller {
 public:
  explicit Controller(const ControllerSettings& settings);

  /// Call before the tick at `now` with the measured body, the feet from the joint angles, and
  /// their contacts. Edits the schedule and sets the data of the tick.
  void observe(double now, const State<double>& x, const PerLeg<double>& feet,
               const Touching& touching);

  RecedingHorizonController& planner() { return planner_; }
  const Gait& gait() const { return gait_; }
  const std::array<LegCommand, legs>& commands() const { return commands_; }
  const Tick<double>& tick() const { return tick_; }

 private:
  Vec<double, 3> velocity_wanted(double yaw) const;
  Vec<double, 3> foothold(int leg, const State<double>& x, double seconds) const;
  LegCommand swing(int leg, double now, const Vec<double, 3>& foot) const;

  ControllerSettings settings_;
  Gait gait_;
  RecedingHorizonController planner_;
  Tick<double> tick_;
  PerLeg<double> lifted_from_ = PerLeg<double>::Zero();
  std::array<double, legs> ground_{};  // height of each foot at its last stance, m
  std::array<bool, legs> stood_{};
  std::array<LegCommand, legs> commands_;
  bool has_begun_ = false;
};

}  // namespace saltus::quadruped
