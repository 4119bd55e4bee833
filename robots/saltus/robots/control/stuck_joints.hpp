// Finds joints that stick: they are driven and do not move.
#pragma once

#include "saltus/core/types.hpp"
#include "saltus/robots/whole_body/robot.hpp"

namespace saltus::robots::control {

/// Watches all joints. A joint that has not moved by `motion` for `time` sticks if it should have
/// gained speed meanwhile: by the accelerations that the controller expects or, if it expects none,
/// because a torque of at least `torque` times the largest one acted all the time. Does not
/// allocate after construction.
class StuckJoints {
 public:
  /// Thresholds.
  struct Options {
    double time = 0.2;     ///< s; 0: nothing is watched
    double motion = 2e-3;  ///< rad
    double speed = 1.0;    ///< speed that the joint should have gained, rad/s
    double torque = 0.5;   ///< fraction of the largest torque
  };
  /// `effort`: largest torques, Nm.
  StuckJoints(VectorXd effort, Options options);

  /// Starts with joints at q (rad).
  void start(const VectorXd& q);
  /// Index of a joint that sticks, or -1, `dt` seconds after the last call. `commands` act on
  /// joints with these speeds. `accelerations`: expected ones, rad/s^2, or null.
  Eigen::Index update(double dt, const VectorXd& q, const VectorXd& dq,
                      const Robot::Commands& commands, const VectorXd* accelerations);
  /// Largest speed that a joint without motion should have gained so far, rad/s.
  double worst() const { return worst_; }

 private:
  VectorXd effort_;
  Options options_;
  VectorXd from_, still_, gained_,
      pushed_;  // last place, time there, speed to gain, time of torque
  double worst_ = 0.0;
};

}  // namespace saltus::robots::control
