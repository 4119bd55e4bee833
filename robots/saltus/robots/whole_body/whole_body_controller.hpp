// Whole-body controllers: joint torques from tasks for momentum, feet and posture. There are two
// methods, inverse dynamics and momentum control. A DriveController converts torques to commands.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "saltus/qp/qp_result.hpp"
#include "saltus/robots/model/contact_cone.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Computes joint torques that carry out tasks.
class WholeBodyController {
 public:
  /// Tasks of a whole-body controller. Wrenches are (fx, fy, fz, tx, ty, tz) in the axes of their
  /// sole.
  struct Tasks {
    bool left_stands = true, right_stands = true;    ///< feet that may carry load
    Vec<double, 3> force = Vec<double, 3>::Zero();   ///< rate of linear momentum, N
    Vec<double, 3> torque = Vec<double, 3>::Zero();  ///< rate of angular momentum about the CoM, Nm
    Vec<double, 12> wrenches = Vec<double, 12>::Zero();  ///< planned wrenches, left and right
    /// Acceleration of the swing foot: d twist / dt, (angular | linear), world axes.
    Vec<double, 6> swing_acceleration = Vec<double, 6>::Zero();
    /// Accelerations of the left and right foot while they stand, in addition to the damping.
    Vec<double, 6> left_hold = Vec<double, 6>::Zero(), right_hold = Vec<double, 6>::Zero();
    VectorXd posture;  ///< desired joint positions, rad
    /// Supported parts of the soles, in the sole frames. Empty: the rectangles of the robot.
    /// Momentum control ignores them.
    std::optional<FootRectangle> left_support, right_support;
    /// Largest vertical forces on the feet, N. Momentum control ignores them.
    double left_most_load = infinity, right_most_load = infinity;
  };

  /// Torques, and diagnostics of their computation.
  struct Command {
    VectorXd torques;                                     ///< Nm, within their limits
    VectorXd joint_acceleration;                          ///< rad/s^2
    Vec<double, 12> wrenches = Vec<double, 12>::Zero();   ///< expected wrenches, axes of the soles
    qp::QpStatus status = qp::QpStatus::invalid_problem;  ///< status of the quadratic program
    int iterations = 0;                                   ///< iterations of the quadratic program
    double solve_seconds = 0.0;  ///< processor time of the quadratic program
    double stance_slip = 0.0;    ///< largest entry of a stance foot's acceleration that remains
    double limit_excess = 0.0;   ///< violation of a joint limit, rad/s^2
    int torques_cut = 0;         ///< number of joints whose torque was cut to its limit
  };

  /// Weights of the cost terms and penalties.
  struct Weights {
    double linear_momentum = 1.0;    ///< per N^2
    double angular_momentum = 10.0;  ///< per (Nm)^2
    double posture = 0.01;           ///< per (rad/s^2)^2
    double swing_foot = 100.0;       ///< per (m/s^2)^2 and (rad/s^2)^2
    double wrench = 1e-3;            ///< deviation from the planned wrenches, per N^2, (Nm)^2
    double stance_weight = 1e4;      ///< L1, per m/s^2 and rad/s^2
    double limit_weight = 1e5;       ///< L1, per rad/s^2
    double clearance_weight = 1e5;   ///< L1, per m/s^2
  };

  /// Gains of the tasks.
  struct Gains {
    double posture = 100.0, posture_damping = 20.0;  ///< 1/s^2, 1/s
    double stance_damping = 50.0;  ///< 1/s, on the remaining twist of a stance foot
    /// Turns a sole back that has tipped onto a corner. The requested wrench keeps its centre of
    /// pressure away from the loaded edges, by this factor times the height of the opposite edges,
    /// but at most by a largest distance (m). Heights below a threshold (m) are attributed to
    /// errors of the estimate. 0 switches this off.
    double tipped_reserve = 0.0, most_tipped_reserve = 0.01, tipped_threshold = 3e-4;
    double limit_horizon = 0.05;  ///< s, time constant of the approach to a joint's limit
    double limit_margin = 0.01;   ///< rad, distance kept from the limits
    /// Keeps joints below their largest speeds, less a margin, and lets them brake in time for
    /// their limits.
    bool speed_limits = false;
    double speed_margin = 0.1;  ///< fraction of the largest speed
    double braking = 50.0;      ///< deceleration, rad/s^2
    /// Speed margin of the swing leg. The impact with the ground accelerates its joints, especially
    /// with a straight knee.
    double swing_speed_margin = 0.25;
    double speed_approach = 200.0;  ///< 1/s, rate at which a joint approaches its largest speed
    double velocity_age = 0.0;      ///< s, age of the joint velocities passed to control()
    /// Keeps the capsules of `FloatingRobot::apart` apart by a margin (m), or by half of their
    /// distance in the standing posture. They approach this distance with a time constant (s), as
    /// joints approach their limits.
    bool clearance = false;
    double clearance_margin = 0.005, clearance_horizon = 0.1;  ///< margin, m; time constant, s
  };

  /// Options of momentum control.
  struct MomentumOptions {
    double linear_momentum = 1.0;    ///< per N^2
    double angular_momentum = 10.0;  ///< per (Nm)^2
    double wrench = 1e-3;            ///< deviation from the planned wrenches, per N^2, (Nm)^2
    double torque = 0.0;             ///< per (Nm)^2
    double posture = 50.0, posture_damping = 14.0;  ///< 1/s^2, 1/s
    double stance_damping = 50.0;  ///< 1/s, on the remaining twist of a stance foot
    /// Damping of the pseudo-inverse, on accelerations of the feet: m/s^2 and rad/s^2 per Nm.
    double stance_regularisation = 1e-3, swing_regularisation = 0.1;
    double limit_horizon = 0.05;  ///< s; only to report that a joint runs into its limit
  };

  /// Method of the whole-body controller.
  enum class Method { inverse_dynamics, momentum };

  /// Method, period and options of the whole-body controller.
  struct Options {
    double period = 0.002;                     ///< control period, s
    Method choice = Method::inverse_dynamics;  ///< method
    Weights inverse_dynamics;                  ///< weights of inverse dynamics
    Gains gains;                               ///< gains of inverse dynamics
    MomentumOptions momentum;                  ///< options of momentum control
    bool joint_speed_limits = false;  ///< limit joint speeds; not available with momentum control
    bool self_collision = false;      ///< keep limbs apart and let them collide; not available with
                                      ///< momentum control
  };

  virtual ~WholeBodyController() = default;
  /// Sets the posture in which the robot will stand. Limbs that are close to each other in it need
  /// no larger distance later.
  virtual void stand(const WholeBodyState&) {}
  /// Computes the torques. The model must be updated to `state`. Does not allocate. If the program
  /// is not solved, the torques of the last call are kept.
  virtual const Command& control(const DynamicsModel& model, const WholeBodyState& state,
                                 const Tasks& tasks) noexcept = 0;
};

/// Compensates friction, and lets the drives act as springs and dampers around the motion that the
/// whole-body controller intends. Errors of its model, such as unknown friction, then cause a small
/// deviation instead of a wrong acceleration. The intended motion is the integral of the joint
/// accelerations, and follows the measured motion with a time constant. After construction only
/// start() allocates.
class DriveController {
 public:
  /// Options of the commands.
  struct Options {
    /// Stiffness and damping as multiples of the largest torque of each joint, 1/rad and s/rad.
    double stiffness = 0.0, damping = 0.0;
    double follow = 0.1;  ///< s, time constant with which the intended motion follows the measured
  };

  /// `robot` has the drives that the controller assumes, `period` (s) is that of update(). Throws
  /// DefinitionError for options that are negative or not finite, and for times that are not
  /// positive.
  DriveController(const FloatingRobot& robot, const Options& options, double period);

  /// Starts at rest in q, rad.
  void start(const VectorXd& q);
  /// Commands until the next call. The reference stays valid.
  const Robot::Commands& update(const WholeBodyController::Command& command,
                                const WholeBodyState& state);
  /// Result of the last update().
  const Robot::Commands& commands() const { return commands_; }

 private:
  Options options_;
  double period_;
  std::vector<JointDrive> drives_;
  VectorXd position_, velocity_;  // intended motion, rad and rad/s
  bool has_springs_;
  Robot::Commands commands_;
};

// Whole-body controller by inverse dynamics: one quadratic program per call.
//
// Unknowns: joint accelerations d2q and the wrenches of the feet on the ground. The six equations
// of the free base give its acceleration, and d2q and the wrenches give the torques, so both are
// affine in the unknowns. Hard constraints: torque limits and contact cones, which are always
// feasible. Soft constraints with individual penalties: stance feet do not move, joints stay within
// limits and limbs stay apart. All other tasks are weighted costs.

/// Creates a controller by inverse dynamics, with one quadratic program per control step.
std::unique_ptr<WholeBodyController> make_inverse_dynamics_controller(
    const FloatingRobot& robot, const ContactCone::Options& left, const ContactCone::Options& right,
    const WholeBodyController::Weights& weights = {}, const WholeBodyController::Gains& gains = {});

// Whole-body controller by momentum control in two levels, the reference method of the literature.
// Level 1 finds wrenches that give the requested rate of momentum. Level 2 finds torques with which
// the feet transmit them. After Nava, Romano, Nori, Pucci, "Stability analysis and design of
// momentum-based controllers for humanoid robots", 2016.
//
// Level 1 is a quadratic program over the wrenches f of the stance feet, within their cones:
//   min |rate(f) - wanted|^2 + weights on |f - planned|^2 and on |tau(f)|^2.
// Level 2 uses the Jacobians J and accelerations a of both feet, J_s of the stance feet, the
// selection S of the joints, Lambda = J M^-1 S and N = I - Lambda^+ Lambda:
//   tau(f) = Lambda^+ (J M^-1 (h - J_s' f) - dJ/dt nu + a) + N tau_0,
// where tau_0 gives the joints the accelerations of the posture without constraints by the feet. A
// stance foot has zero acceleration. A swing foot tracks its task in the same equation. Its
// pseudo-inverse has a larger damping, because straight legs are singular.
//
// The method ignores torque limits, which are applied by cutting afterwards, and joint limits. The
// inverse-dynamics program respects both.

/// Creates a momentum controller. Throws DefinitionError for an option that is negative or not
/// finite, and for zero if the solution would not be unique: wrench, regularisations,
/// limit_horizon.
std::unique_ptr<WholeBodyController> make_momentum_controller(
    const FloatingRobot& robot, const ContactCone::Options& left, const ContactCone::Options& right,
    const WholeBodyController::MomentumOptions& options = {});

/// Creates the chosen controller for this robot and these soles.
std::unique_ptr<WholeBodyController> make_whole_body_controller(
    const FloatingRobot& robot, const ContactCone::Options& left, const ContactCone::Options& right,
    const WholeBodyController::Options& control);

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using WholeBodyController [[deprecated("use robots::WholeBodyController; removed in 0.4")]] =
    robots::WholeBodyController;
/// Deprecated name.
using WholeBodyTasks [[deprecated("use robots::WholeBodyController::Tasks; removed in 0.4")]] =
    robots::WholeBodyController::Tasks;
/// Deprecated name.
using WholeBodyCommand [[deprecated("use robots::WholeBodyController::Command; removed in 0.4")]] =
    robots::WholeBodyController::Command;
/// Deprecated name.
using WholeBodyWeights [[deprecated("use robots::WholeBodyController::Weights; removed in 0.4")]] =
    robots::WholeBodyController::Weights;
/// Deprecated name.
using WholeBodyGains [[deprecated("use robots::WholeBodyController::Gains; removed in 0.4")]] =
    robots::WholeBodyController::Gains;
/// Deprecated name.
using MomentumOptions
    [[deprecated("use robots::WholeBodyController::MomentumOptions; removed in 0.4")]] =
        robots::WholeBodyController::MomentumOptions;
/// Deprecated name.
using WholeBodyChoice [[deprecated("use robots::WholeBodyController::Method; removed in 0.4")]] =
    robots::WholeBodyController::Method;
/// Deprecated name.
using WholeBodyControl [[deprecated("use robots::WholeBodyController::Options; removed in 0.4")]] =
    robots::WholeBodyController::Options;
using robots::make_inverse_dynamics_controller;  ///< deprecated name
using robots::make_momentum_controller;          ///< deprecated name
using robots::make_whole_body_controller;        ///< deprecated name
}  // namespace saltus
