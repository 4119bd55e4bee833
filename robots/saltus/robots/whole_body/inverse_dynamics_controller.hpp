// Whole-body controller by inverse dynamics: one quadratic program per call.
//
// Unknowns: joint accelerations d2q and the wrenches of the feet on the ground. The six equations
// of the free base give its acceleration, and d2q and the wrenches give the torques, so both are
// affine in the unknowns. Hard constraints: torque limits and contact cones, which are always
// feasible. Soft constraints with individual penalties: stance feet do not move, joints stay within
// limits and limbs stay apart. All other tasks are weighted costs.
#pragma once

#include <memory>

#include "saltus/robots/model/contact_cone.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus {

/// Weights of the cost terms and penalties.
struct WholeBodyWeights {
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
struct WholeBodyGains {
  double posture = 100.0, posture_damping = 20.0;  ///< 1/s^2, 1/s
  double stance_damping = 50.0;                    ///< 1/s, on the remaining twist of a stance foot
  /// Turns a sole back that has tipped onto a corner. The requested wrench keeps its centre of
  /// pressure away from the loaded edges, by this factor times the height of the opposite edges,
  /// but at most by a largest distance (m). Heights below a threshold (m) are attributed to errors
  /// of the estimate. 0 switches this off.
  double tipped_reserve = 0.0, most_tipped_reserve = 0.01, tipped_threshold = 3e-4;
  double limit_horizon = 0.05;  ///< s, time constant of the approach to a joint's limit
  double limit_margin = 0.01;   ///< rad, distance kept from the limits
  /// Keeps joints below their largest speeds, less a margin, and lets them brake in time for their
  /// limits.
  bool speed_limits = false;
  double speed_margin = 0.1, braking = 50.0;  ///< speed margin as a fraction; deceleration, rad/s^2
  /// Speed margin of the swing leg. The impact with the ground accelerates its joints, more so for
  /// a straight knee.
  double swing_speed_margin = 0.25;
  double speed_approach = 200.0;  ///< 1/s, rate at which a joint approaches its largest speed
  double velocity_age = 0.0;      ///< s, age of the joint velocities passed to control()
  /// Keeps the capsules of `FloatingRobot::apart` apart by a margin (m), or by half of their
  /// distance in the standing posture. They approach this distance with a time constant (s), as
  /// joints approach their limits.
  bool clearance = false;
  double clearance_margin = 0.005, clearance_horizon = 0.1;  ///< margin, m; time constant, s
};

/// Creates a controller by inverse dynamics, with one quadratic program per control step.
std::unique_ptr<WholeBodyController> make_inverse_dynamics_controller(
    const FloatingRobot& robot, const ContactConeOptions& left, const ContactConeOptions& right,
    const WholeBodyWeights& weights = {}, const WholeBodyGains& gains = {});

}  // namespace saltus
