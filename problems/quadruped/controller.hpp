// From what is measured to what the robot is told: gait, footholds, the plan's data, swing legs.
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
  double period = 0.01;                // of the ticks, s
  double height = 0.29;                // of the CoM above the feet, m
  double speed = 0.4, sideways = 0.0;  // m/s, in the axes of the body
  double turn = 0.0;                   // rad/s
  double clearance = 0.08;             // of a swing foot, m
  double landing_speed = 1.0;   // m/s, downwards; a foot that is late looks for the ground so fast
  double foothold_gain = 0.12;  // on the error of the velocity, s
  double longest_step = 0.22;   // of a foot from below its hip, m
};

class Controller {
 public:
  explicit Controller(const ControllerSettings& settings);

  /// Before the tick at `now`, with the body as measured, the feet as the joints say where they
  /// are, and which of them feel the ground: the schedule is edited and the data of the tick set.
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
  std::array<double, legs> ground_{};  // height of each foot's last stand, m
  std::array<bool, legs> stood_{};
  std::array<LegCommand, legs> commands_;
  bool has_begun_ = false;
};

}  // namespace saltus::quadruped
