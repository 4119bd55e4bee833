// Settings of the step planner: its type, and the limits and weights of the planner by optimal
// control.
#pragma once

#include <memory>
#include <optional>

#include "problems/biped/survey/foot_reach.hpp"
#include "problems/push_recovery/step_choice.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_logic.hpp"

namespace saltus::push_recovery {

struct StepPlanning {
  int most_steps = 2;
  double usual = 0.35;          ///< usual time of a swing, s
  double shortest = 0.3;        ///< shortest swing, s
  double longest = 0.9;         ///< longest swing, s
  double foot_speed = 2.0;      ///< largest speed of the swing foot, m/s
  double double_support = 0.1;  ///< shortest double support between two steps, s
  double sole_margin = 0.006;   ///< unused border of the soles, m
  double momentum = 0.4;        ///< largest |H| about either horizontal axis, Nms
  double torque = 5.0;          ///< largest rate of angular momentum, Nm
  bool robot_reach = true;      ///< reach from the kinematics of the robot, else from the settings
  double price = 2.0;           ///< cost of a step, in units of the total cost
  double hysteresis = 0.5;      ///< in units of the cost
  /// Desired walking velocity: forward, left (m/s) and yaw rate (rad/s).
  Vec<double, 3> velocity = Vec<double, 3>::Zero();
  double walk_duration = 20.0;                 ///< time after which the robot stands, s
  bool bring_back = false;                     ///< return feet to their usual distance once at rest
  double walking_swing = 0.4;                  ///< usual time of a swing while walking, s
  double usual_support = 0.1;                  ///< usual double support while walking, s
  Vec<double, 4> weights{1.0, 1.0, 1.0, 1.0};  ///< rest, duration, stride, pressure: StepWeights
  double lead = 0.08;  ///< time before the landing at which its time and place are fixed, s

  bool walks() const { return !velocity.isZero(0.0); }
  /// True if steps follow a task and not a push. The wrench planner must then follow the planned
  /// motion.
  bool leads_the_way() const { return walks() || bring_back; }
};

/// Declares step.planner and the keys of the planner by optimal control.
void declare_settings(Settings& settings, StepPlanning& planning, robots::walking::Step& step);

/// Creates the planner for the robot of this scene. `step` gives the usual place, and the reach if
/// the robot's own is not available.
std::unique_ptr<robots::walking::StepPlanner> make_step_choice(
    const StepPlanning& planning, const robots::walking::Step& step,
    const robots::walking::Scene& scene, double mass,
    const std::optional<survey::FootReach>& reach = std::nullopt);

/// Reach given by the settings. The legs are long enough for a step to both sides.
survey::FootReach reach_of(const robots::walking::Step& step);

/// Reach computed from the URDF, if the settings request it and there is a URDF.
std::optional<survey::FootReach> reach_of_robot(const StepPlanning& planning,
                                                const robots::walking::RobotChoice& choice,
                                                const robots::RobotDescription& robot);

}  // namespace saltus::push_recovery
