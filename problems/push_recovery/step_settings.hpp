// What the planner of steps can be told: which one it is, and the limits and prices of the one that
// solves an optimal control problem.
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
  double usual = 0.35;          ///< time of a swing, s
  double shortest = 0.3;        ///< swing, s
  double longest = 0.9;         ///< swing, s
  double foot_speed = 2.0;      ///< largest of the swing foot, m/s
  double double_support = 0.1;  ///< shortest between two steps, s
  double sole_margin = 0.006;   ///< of the border of the soles, not used, m
  double momentum = 0.4;        ///< largest |H| about either horizontal axis, Nms
  double torque = 5.0;          ///< largest rate of it, Nm
  bool robot_reach = true;      ///< of its own kinematics, else that of the settings
  double price = 2.0;           ///< of a step, in units of the cost
  double hysteresis = 0.5;      ///< in units of the cost
  Vec<double, 3> velocity = Vec<double, 3>::Zero();  ///< to walk with: forward, left (m/s), turn
  double walk_duration = 20.0;                       ///< then it stands, s
  bool bring_back = false;                           ///< feet to their usual distance, once at rest
  double usual_support = 0.1;                        ///< of who walks, on two feet, s
  Vec<double, 4> weights{1.0, 1.0, 1.0, 1.0};  ///< rest, duration, stride, pressure: StepWeights
  double lead = 0.08;  ///< s before the landing its time and place are fixed

  bool walks() const { return !velocity.isZero(0.0); }
  /// Steps for their own sake: whoever carries them out has to follow the plan.
  bool leads_the_way() const { return walks() || bring_back; }
};

/// step.planner and the keys of the one that solves a problem of optimal control.
void declare_settings(Settings& settings, StepPlanning& planning, walking::Step& step);

/// For the robot of this scene; `step` has its usual place, and its reach as long as the
/// robot's own is not given.
std::unique_ptr<walking::StepPlanner> make_step_choice(
    const StepPlanning& planning, const walking::Step& step, const walking::Scene& scene,
    double mass, const std::optional<survey::FootReach>& reach = std::nullopt);

/// As the settings have it. The legs are as long as a step to both sides.
survey::FootReach reach_of(const walking::Step& step);

/// Of the robot's URDF, if the settings ask for it and there is one.
std::optional<survey::FootReach> reach_of_robot(const StepPlanning& planning,
                                                const walking::RobotChoice& choice,
                                                const RobotDescription& robot);

}  // namespace saltus::push_recovery
