// Controller of a walking robot: from sensor readings to joint commands.
//
// Its parts run at different rates: Estimator and ContactEstimator with all readings,
// WholeBodyController at the control period, StepPlanner and Planner (BalancePlanner) at the
// planner period. On the centroidal model BalancePlanner alone drives the plant.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/robots/walking/planner.hpp"
#include "saltus/robots/walking/step_planner.hpp"
#include "saltus/robots/whole_body/contact_estimator.hpp"
#include "saltus/robots/whole_body/corrected_model.hpp"
#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/estimator.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus::robots {
class FootSupport;
class StanceFoot;
class SwingFoot;
class SwingOrientation;
}  // namespace saltus::robots

namespace saltus::robots::walking {

/// Plans the wrenches and steps of a biped. Each tick calls plan_steps(), land() if the swing foot
/// has landed, and plan_wrenches(). Between ticks land() may be called, and note_contacts() after
/// it. Does not allocate after construction.
class BalancePlanner {
 public:
  /// State of the robot as the planners use it, in world axes.
  struct Estimate {
    /// CoM m, velocity m/s, angular momentum about the CoM Nms.
    Vec<double, 9> gamma = Vec<double, 9>::Zero();
    double mass = 0.0;                                       ///< mass of the controllers' model, kg
    SoleFrame left_sole, right_sole;                         ///< contact frames, m
    Vec<double, 3> left_velocity = Vec<double, 3>::Zero();   ///< velocity of its origin, m/s
    Vec<double, 3> right_velocity = Vec<double, 3>::Zero();  ///< velocity of its origin, m/s
    /// Wrenches applied at present, left and right, axes of the level soles, N and Nm.
    Vec<double, 12> applied = Vec<double, 12>::Zero();
    Vec<double, 3> contact_force = Vec<double, 3>::Zero();  ///< sum of their forces, N
    /// Supported parts of the soles, in their frames. Empty: the rectangles of the robot.
    std::optional<FootRectangle> left_support, right_support;

    /// Contact frame of one foot.
    const SoleFrame& sole(Side foot) const { return foot == Side::left ? left_sole : right_sole; }
    /// Supported part of one sole.
    const std::optional<FootRectangle>& support(Side foot) const {
      return foot == Side::left ? left_support : right_support;
    }
    /// Velocity of the origin of the sole.
    const Vec<double, 3>& sole_velocity(Side foot) const {
      return foot == Side::left ? left_velocity : right_velocity;
    }
  };

  /// Time at which contacts change: at the planned landing, or when the foot touches the ground. A
  /// doubted landing is never planned within the next tick. Otherwise wrenches that prepare it
  /// unload the stance foot, although the ground may be lower than expected.
  enum class LandingTime { as_planned, when_felt, doubted };

  /// `period`: control period of both planners, s.
  BalancePlanner(const Scene& scene, Schedule contacts, std::unique_ptr<StepPlanner> steps,
                 std::unique_ptr<Planner> wrenches, double period, LandingTime landing);

  /// Changes made by plan_steps().
  struct StepChange {
    bool has_begun = false;   ///< True if a step has begun.
    bool has_lifted = false;  ///< True if the foot of the step was on the ground before.
    bool has_target = false;  ///< True if step() has a new time and place.
  };
  /// Plans the next steps. A step whose lift-off is due begins.
  StepChange plan_steps(double t, const Estimate& measured);
  /// Records that the swing foot stands at `place` (m) from `t` on.
  void land(double t, const Vec<double, 3>& place);
  /// Records that the foot that landed last has lost its contact. It continues its step.
  void take_back();
  /// Sets the desired angular momentum about the vertical, Nms.
  void turn(double yaw_momentum) { scene_.yaw_momentum = yaw_momentum; }
  /// Plans the wrenches until the next tick.
  void plan_wrenches(double t, const Estimate& measured);
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
  const StepPlan::Step& step() const { return step_; }
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
  StepSituation situation(double t, const Estimate& measured) const;
  void schedule(double t);

  Scene scene_;
  Schedule contacts_;
  std::unique_ptr<StepPlanner> steps_;
  std::unique_ptr<Planner> planner_;
  double period_;
  LandingTime landing_;
  std::array<Foot, 2> feet_;
  StepPlan plan_;
  StepPlan::Step step_;
  bool is_stepping_ = false;
  const ControlTick* tick_ = nullptr;
};

/// Controller of a biped, from sensor readings to joint commands. Call start() once, then update()
/// once for each set of readings. After start() nothing allocates.
class BalanceController {
 public:
  /// Parts of a BalanceController.
  struct Parts {
    std::unique_ptr<Estimator> estimator;             ///< from readings to the state
    std::unique_ptr<DynamicsModel> model;             ///< dynamics of the controllers' model
    std::unique_ptr<WholeBodyController> whole_body;  ///< from wrenches to torques
    std::unique_ptr<DriveController> drives;          ///< optional: from torques to commands
    std::unique_ptr<StepPlanner> steps;               ///< decides on steps
    std::unique_ptr<Planner> wrenches;                ///< plans wrenches
    std::unique_ptr<CorrectedModel> corrected;        ///< optional, instead of `model`
  };

  /// Rates and start of a BalanceController.
  struct Options {
    double period = 0.001;          ///< time between two readings, s
    double control_period = 0.002;  ///< period of the whole-body controller, s: a multiple of
                                    ///< `period`
    double planner_period = 0.01;   ///< period of the planners, s: a multiple of `control_period`
    ContactEstimator::Options contact{};  ///< landings and lost contacts of the swing foot
    StanceFootOptions stance{};           ///< hold of standing feet
    FootSupportOptions support{};         ///< estimate of the ground below them
    SwingOptions swing{};                 ///< motion of the swing foot
    Scene scene;                          ///< feet and target at the start
    Schedule contacts;                    ///< contacts known at the start
  };

  /// Counts and times of a run, for logs.
  struct Statistics {
    long calls = 0, failures = 0;  ///< whole-body controller; failures have no solution
    long cuts = 0;                 ///< calls in which torques were cut to their limits
    LatencyHistogram solves;       ///< processor time of the solutions
    /// Processor time of planners and whole-body control, and of the last plan of steps, s.
    double plan_seconds = 0.0, control_seconds = 0.0, step_seconds = 0.0;
  };

  /// Throws DefinitionError if a part is missing or the periods are not multiples of each other.
  BalanceController(Parts parts, Options options);
  ~BalanceController();
  BalanceController(BalanceController&&) noexcept;
  BalanceController& operator=(BalanceController&&) noexcept;

  /// Starts at rest in `state` with the first readings, which are those of the first update(). The
  /// planners count time from these readings, so times in planner() begin at zero.
  void start(const WholeBodyState& state, const Robot::Readings& readings);
  /// Computes the commands for these readings. They act until the next update(). The reference
  /// stays valid.
  const Robot::Commands& update(const Robot::Readings& readings);

  /// Optional, between two updates and on any thread: does the work for the tick with readings at
  /// `t` (s, their clock) that does not need these readings.
  void prepare(double t) { planner_.planner().controller().prepare(t - start_time_); }

  /// Events of the last update(), for logs.
  struct Update {
    double time = 0.0;            ///< time of its readings, s
    bool has_controlled = false;  ///< True if the whole-body controller has run.
    bool has_planned = false;     ///< True if the planners have run.
    bool has_landed = false;      ///< True if the swing foot has landed.
    bool has_lost = false;        ///< True if a landed foot has lost its contact and swings again.
    BalancePlanner::StepChange step;  ///< changes of the step
  };
  const Update& last() const { return update_; }  ///< record of update()
  /// Current estimate of the robot.
  const WholeBodyEstimate& estimate() const { return parts_.estimator->estimate(); }
  /// Estimate used by the planners, at the last call of the whole-body controller.
  BalancePlanner::Estimate centroidal_estimate() const;
  const DynamicsModel& model() const { return *parts_.model; }  ///< model at that estimate
  /// Model with estimated mass and CoM; null if they are not estimated.
  const CorrectedModel* corrected_model() const { return corrected_; }
  const Robot::Commands& commands() const { return commands_; }  ///< result of the last update()
  const WholeBodyController::Tasks& tasks() const {
    return tasks_;
  }  ///< tasks of the whole-body controller
  const BalancePlanner& planner() const { return planner_; }    ///< steps and wrenches
  BalancePlanner& planner() { return planner_; }                ///< steps and wrenches
  const Statistics& statistics() const { return statistics_; }  ///< since start()
  const Vec<double, 12>& applied() const { return applied_; }   ///< expected wrenches
  Side swing_side() const { return swing_side_; }               ///< foot that swings, or swung last

 private:
  void plan(double t);
  void find_contact(double t);
  void control(double t);
  void observe_mass();
  void scale_to_described_mass(BalancePlanner::Estimate& e) const;
  void aim_swing(double t, const StepPlan::Step& step);
  /// True if steps follow a planned motion of the CoM, on ground that may not be level.
  bool walks() const { return planner_.plan().motion.samples > 0; }
  Vec<double, 2> feet_heading() const;
  double yaw_momentum() const;
  std::unique_ptr<FootSupport> make_support(Side side) const;
  FootSupport& support(Side foot) { return *support_[foot == Side::left ? 0 : 1]; }
  const FootSupport& support(Side foot) const { return *support_[foot == Side::left ? 0 : 1]; }
  StanceFoot& stance(Side foot) { return *stance_[foot == Side::left ? 0 : 1]; }
  bool& stands(Side foot) { return foot == Side::left ? tasks_.left_stands : tasks_.right_stands; }

  CorrectedModel* corrected_ = nullptr;  // the model, if it is corrected
  Parts parts_;
  Options options_;
  long per_control_, per_plan_, updates_ = 0;
  double start_time_ = 0.0;  // of the first readings, s
  BalancePlanner planner_;
  ContactEstimator contact_;
  std::unique_ptr<SwingFoot> swing_;
  std::unique_ptr<SwingOrientation> orientation_;
  std::array<std::unique_ptr<StanceFoot>, 2> stance_;
  std::array<std::unique_ptr<FootSupport>, 2> support_;
  Side swing_side_;
  Vec<double, 3> ground_normal_ = Vec<double, 3>::UnitZ();  // below the stance foot
  // Axis of the base that points along the mean heading of the feet at the start.
  Vec<double, 3> forward_ = Vec<double, 3>::UnitX();
  WholeBodyController::Tasks tasks_;
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
  Vec<double, 12> expected_ = Vec<double, 12>::Zero();  // the same, axes of the soles
  Robot::Commands commands_;
  Update update_;
  Statistics statistics_;
};

}  // namespace saltus::robots::walking
