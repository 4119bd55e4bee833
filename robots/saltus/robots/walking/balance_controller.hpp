// Controller of a walking robot: from sensor readings to joint commands.
//
// Its parts run at different rates: Estimator and ContactEstimator with all readings,
// WholeBodyController at the control period, StepPlanner and Planner (BalancePlanner) at the
// planner period.
#pragma once

#include <memory>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/robots/walking/balance_planner.hpp"
#include "saltus/robots/whole_body/contact_estimator.hpp"
#include "saltus/robots/whole_body/estimator.hpp"
#include "saltus/robots/whole_body/swing_foot.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus::walking {

/// Parts of a BalanceController.
struct BalanceParts {
  std::unique_ptr<Estimator> estimator;             ///< from readings to the state
  std::unique_ptr<DynamicsModel> model;             ///< dynamics of the controllers' model
  std::unique_ptr<WholeBodyController> whole_body;  ///< from wrenches to torques
  std::unique_ptr<StepPlanner> steps;               ///< decides on steps
  std::unique_ptr<Planner> wrenches;                ///< plans wrenches
};

/// Rates and start of a BalanceController.
struct BalanceOptions {
  double period = 0.001;          ///< time between two readings, s
  double control_period = 0.002;  ///< period of the whole-body controller, s: a multiple of
                                  ///< `period`
  double planner_period = 0.01;   ///< period of the planners, s: a multiple of `control_period`
  double landing_force = 20.0;    ///< vertical force on a foot that has landed, N
  Scene scene;                    ///< feet and target at the start
  Schedule contacts;              ///< contacts known at the start
};

/// Counts and times of a run, for logs.
struct BalanceStatistics {
  long calls = 0, failures = 0;  ///< of the whole-body controller; failures have no solution
  long cuts = 0;                 ///< calls in which torques were cut to their limits
  LatencyHistogram solves;       ///< processor time of the solutions
  /// Processor time of planners and whole-body control, and of the last plan of steps, s.
  double plan_seconds = 0.0, control_seconds = 0.0, step_seconds = 0.0;
};

/// Call start() once, then update() once for all readings. After start() nothing allocates.
class BalanceController {
 public:
  /// Throws DefinitionError if a part is missing or the periods are not multiples of each other.
  BalanceController(BalanceParts parts, BalanceOptions options);

  /// Starts at rest in `state` with the first readings, which are those of the first update().
  void start(const WholeBodyState& state, const SensorReadings& readings);
  /// Computes the commands for these readings. They act until the next update(). The reference
  /// stays valid.
  const JointCommands& update(const SensorReadings& readings);

  /// Optional, between two updates and on any thread: does the work for the tick at `t` (s) that
  /// does not need its readings.
  void prepare(double t) { planner_.planner().controller().prepare(t); }

  /// Events of the last update(), for logs.
  struct Update {
    double time = 0.0;                ///< time of its readings, s
    bool has_controlled = false;      ///< True if the whole-body controller has run.
    bool has_planned = false;         ///< True if the planners have run.
    bool has_landed = false;          ///< True if the swing foot has landed.
    BalancePlanner::StepChange step;  ///< changes of the step
  };
  const Update& last() const { return update_; }  ///< record of update()
  /// Current estimate of the robot.
  const WholeBodyEstimate& estimate() const { return parts_.estimator->estimate(); }
  /// Estimate used by the planners, at the last call of the whole-body controller.
  CentroidalEstimate centroidal_estimate() const;
  const DynamicsModel& model() const { return *parts_.model; }  ///< model at that estimate
  const JointCommands& commands() const { return commands_; }   ///< result of the last update()
  const WholeBodyTasks& tasks() const { return tasks_; }  ///< tasks of the whole-body controller
  const BalancePlanner& planner() const { return planner_; }           ///< steps and wrenches
  BalancePlanner& planner() { return planner_; }                       ///< steps and wrenches
  const BalanceStatistics& statistics() const { return statistics_; }  ///< since start()
  const Vec<double, 12>& applied() const { return applied_; }          ///< expected wrenches
  Side swing_side() const { return swing_side_; }  ///< foot that swings, or swung last

 private:
  void plan(double t);
  void find_landing(double t);
  void control(double t);
  bool& stands(Side foot) { return foot == Side::left ? tasks_.left_stands : tasks_.right_stands; }

  BalanceParts parts_;
  BalanceOptions options_;
  long per_control_, per_plan_, updates_ = 0;
  BalancePlanner planner_;
  ContactEstimator contact_;
  SwingFoot swing_;
  Side swing_side_;
  WholeBodyTasks tasks_;
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
  JointCommands commands_;
  Update update_;
  BalanceStatistics statistics_;
};

}  // namespace saltus::walking
