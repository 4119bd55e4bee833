// Joint torques from what is asked of momentum, feet and posture: one quadratic program per call.
//
// Unknowns: joint accelerations and the wrenches of the feet on the ground. The six equations of
// the free base give its acceleration, d2q and wrenches the torques, so that both are affine in the
// unknowns. Hard: torque limits and contact cones, which some accelerations always meet. Soft, at
// named penalties: stance feet do not move, joints stay within limits and limbs off each other. The
// rest is weighed.
#pragma once

#include <memory>

#include "saltus/robots/model/contact_cone.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus {

/// Of the terms of inverse dynamics.
struct WholeBodyWeights {
  double linear_momentum = 1.0;    ///< per N^2
  double angular_momentum = 10.0;  ///< per (Nm)^2
  double posture = 0.01;           ///< per (rad/s^2)^2
  double swing_foot = 100.0;       ///< per (m/s^2)^2 and (rad/s^2)^2
  double wrench = 1e-3;            ///< of the difference to the planned wrenches, per N^2, (Nm)^2
  double stance_weight = 1e4;      ///< L1, per m/s^2 and rad/s^2
  double limit_weight = 1e5;       ///< L1, per rad/s^2
  double clearance_weight = 1e5;   ///< L1, per m/s^2
};

/// Of the tasks of inverse dynamics.
struct WholeBodyGains {
  double posture = 100.0, posture_damping = 20.0;  ///< 1/s^2, 1/s
  double stance_damping = 50.0;  ///< 1/s, on what is left of a stance foot's twist
  /// A sole that has tipped onto a corner is turned back: the wrench asked of it keeps its centre
  /// of pressure off the edges that bear by so much of the heights to which the opposite ones were
  /// lifted, at most by a largest distance (m). Heights below a threshold (m) are errors of the
  /// estimate. 0: it may stay.
  double tipped_reserve = 0.0, most_tipped_reserve = 0.01, tipped_threshold = 3e-4;
  double limit_horizon = 0.05;  ///< s, time constant of the approach to a joint's limit
  double limit_margin = 0.01;   ///< rad, kept from the limits
  /// Keeps joints below their largest speeds, less a fraction, and lets them brake in time for
  /// their limits: at this deceleration, rad/s^2.
  bool speed_limits = false;
  double speed_margin = 0.1, braking = 50.0;  ///< that fraction; that deceleration, rad/s^2
  /// In place of the margin for the leg that swings: the ground will throw its joints, the more the
  /// straighter the knee.
  double swing_speed_margin = 0.25;
  double speed_approach = 200.0;  ///< 1/s, how quickly a joint may approach its largest speed
  double velocity_age = 0.0;      ///< s, of the joints' velocities that control() is given
  /// Keeps the capsules of `FloatingRobot::apart` off each other: by this, m, or half of what they
  /// are apart where the robot stands; as for a joint's limit with this time constant, s.
  bool clearance = false;
  double clearance_margin = 0.005, clearance_horizon = 0.1;  ///< that distance, m; that time, s
};

/// Torques by inverse dynamics: one quadratic program per step of control.
std::unique_ptr<WholeBodyController> make_inverse_dynamics_controller(
    const FloatingRobot& robot, const ContactConeOptions& left, const ContactConeOptions& right,
    const WholeBodyWeights& weights = {}, const WholeBodyGains& gains = {});

}  // namespace saltus
