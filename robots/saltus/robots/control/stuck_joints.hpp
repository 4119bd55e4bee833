// Detects stuck joints, which are driven but do not move.
#pragma once

#include <array>

#include "saltus/core/types.hpp"
#include "saltus/robots/whole_body/robot.hpp"

namespace saltus::robots::control {

/// Watches all joints. A joint that has not moved for `time` is stuck if its torque has changed
/// meanwhile, or was close to its limit all the time. A constant torque may hold a load. Does not
/// allocate after construction.
class StuckJoints {
 public:
  /// Thresholds.
  struct Options {
    double time = 0.3;     ///< time without motion, s; 0: no joint counts as stuck
    double motion = 1e-3;  ///< smallest motion, rad
    /// Difference between the mean torques of the last two thirds and of the first third of `time`,
    /// as a fraction of the largest torque.
    double change = 0.3;
    double limit = 0.9;  ///< torque close to its limit, as a fraction of the largest
  };
  /// `effort`: largest torques, Nm.
  StuckJoints(VectorXd effort, Options options);

  /// Starts with joints at q (rad).
  void start(const VectorXd& q);
  /// Returns the index of a stuck joint, or -1. Call it `dt` seconds after the last call.
  /// `commands` act on joints with these positions and velocities.
  Eigen::Index update(double dt, const VectorXd& q, const VectorXd& dq,
                      const Robot::Commands& commands);
  /// Largest change of torque so far of a joint without motion, as a fraction of its largest
  /// torque.
  double worst() const { return worst_; }

 private:
  VectorXd effort_;
  Options options_;
  VectorXd from_, still_, at_limit_;  // last position (rad), time there, time at the limit (s)
  VectorXd sum_;                      // of the torque over the present third, Nm s
  std::array<VectorXd, 3> means_;     // torques of the last thirds, the latest one last
  double third_ = 0.0;                // time since the last third, s
  double worst_ = 0.0;
};

}  // namespace saltus::robots::control
