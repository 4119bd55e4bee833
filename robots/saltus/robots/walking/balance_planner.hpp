// Planner of steps and wrenches. It connects a StepPlanner and a Planner, and tracks which feet
// stand, the step in progress and the scheduled contacts.
#pragma once

#include <array>
#include <memory>

#include "saltus/robots/walking/planner.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus::walking {

/// State of the robot as the planners use it, in world axes.
struct CentroidalEstimate {
  /// CoM m, velocity m/s, angular momentum about the CoM Nms.
  Vec<double, 9> gamma = Vec<double, 9>::Zero();
  double mass = 0.0;                                       ///< mass of the controllers' model, kg
  SoleFrame left_sole, right_sole;                         ///< contact frames, m
  Vec<double, 3> left_velocity = Vec<double, 3>::Zero();   ///< velocity of its origin, m/s
  Vec<double, 3> right_velocity = Vec<double, 3>::Zero();  ///< velocity of its origin, m/s
  /// Wrenches applied at present, left and right, axes of the level soles, N and Nm.
  Vec<double, 12> applied = Vec<double, 12>::Zero();
  Vec<double, 3> contact_force = Vec<double, 3>::Zero();  ///< sum of their forces, N

  /// Contact frame of one foot.
  const SoleFrame& sole(Side foot) const { return foot == Side::left ? left_sole : right_sole; }
  /// Velocity of the origin of the sole.
  const Vec<double, 3>& sole_velocity(Side foot) const {
    return foot == Side::left ? left_velocity : right_velocity;
  }
};

/// Time at which contacts change: at the planned landing, or when the foot touches the ground.
enum class LandingTime { as_planned, when_felt };

/// Each tick calls plan_steps(), land() if the swing foot has landed, and plan_wrenches(). Between
/// ticks land() may be called, and note_contacts() after it. Does not allocate after construction.
class BalancePlanner {
 public:
  /// `period`: control period of both planners, s.
  BalancePlanner(const Scene& scene, Schedule contacts, std::unique_ptr<StepPlanner> steps,
                 std::unique_ptr<Planner> wrenches, double period, LandingTime landing);

  /// Changes made by plan_steps().
  struct StepChange {
    bool has_begun = false;   ///< True if a step has begun.
    bool has_lifted = false;  ///< True if its foot stood before.
    bool has_target = false;  ///< True if step() has a new time and place.
  };
  /// Plans the next steps. A step whose lift-off is due begins.
  StepChange plan_steps(double t, const CentroidalEstimate& measured);
  /// The swing foot stands at `place` (m) from `t` on.
  void land(double t, const Vec<double, 3>& place);
  /// Plans the wrenches until the next tick.
  void plan_wrenches(double t, const CentroidalEstimate& measured);
  /// Records the feet that stand; they carry a wrench at the next tick.
  void note_contacts();

  /// Wrenches at `t` within the tick: left and right, axes of the level soles, N and Nm.
  Eigen::VectorBlock<const VectorXd> wrenches(double t) const;
  /// Result of the wrench planner in this tick.
  const ControlTick& tick() const { return *tick_; }
  /// Result of the step planner in this tick.
  const StepPlan& plan() const { return plan_; }
  /// True if a foot is swinging to a landing.
  bool is_stepping() const { return is_stepping_; }
  /// The step in progress, or the last one.
  const PlannedStep& step() const { return step_; }
  /// True if this foot stands.
  bool stands(Side side) const { return foot(side).stands; }
  /// Feet and target of the CoM.
  const Scene& scene() const { return scene_; }
  /// Planner of wrenches, for logs.
  Planner& planner() { return *planner_; }
  /// Planner of steps, for logs.
  const StepPlanner& step_planner() const { return *steps_; }

 private:
  struct Foot {
    bool stands = false;
    bool bore = false;  // true if it already stood at the last tick
  };
  Foot& foot(Side side) { return feet_[side == Side::left ? 0 : 1]; }
  const Foot& foot(Side side) const { return feet_[side == Side::left ? 0 : 1]; }
  const char* mode_now() const;
  StepSituation situation(double t, const CentroidalEstimate& measured) const;
  void schedule(double t);

  Scene scene_;
  Schedule contacts_;
  std::unique_ptr<StepPlanner> steps_;
  std::unique_ptr<Planner> planner_;
  double period_;
  LandingTime landing_;
  std::array<Foot, 2> feet_;
  StepPlan plan_;
  PlannedStep step_;
  bool is_stepping_ = false;
  const ControlTick* tick_ = nullptr;
};

}  // namespace saltus::walking
