// Joint velocities from joint positions: one critically damped alpha-beta filter per joint (the
// fading-memory polynomial filter of first degree).
#pragma once

#include "saltus/core/types.hpp"

namespace saltus::robots {

/// With predictions q' = q + T dq and r = measured - q': q = q' + alpha r, dq += beta r / T, where
/// alpha = 1 - theta^2, beta = (1 - theta)^2. Under constant acceleration dq lags by T (1 + 3
/// theta) / (2 (1 - theta)). theta is chosen such that this equals the requested lag, or T / 2, the
/// lag of a finite difference, if that is larger.
class JointVelocityFilter {
 public:
  /// T: time between positions, s; lag: lag of the velocity, s.
  JointVelocityFilter(int joints, double T, double lag)
      : T_(T), position_(VectorXd::Zero(joints)), velocity_(VectorXd::Zero(joints)) {
    const double theta = lag > 0.5 * T ? (2.0 * lag - T) / (2.0 * lag + 3.0 * T) : 0.0;
    alpha_ = 1.0 - theta * theta;
    beta_ = (1.0 - theta) * (1.0 - theta);
  }

  /// Starts at rest in q.
  void reset(const VectorXd& q) {
    position_ = q;
    velocity_.setZero();
  }
  /// Processes one measurement. Does not allocate.
  void update(const VectorXd& q) {
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      position_[i] += T_ * velocity_[i];
      const double error = q[i] - position_[i];
      position_[i] += alpha_ * error;
      velocity_[i] += beta_ / T_ * error;
    }
  }
  const VectorXd& velocity() const { return velocity_; }  ///< rad/s

 private:
  double T_, alpha_, beta_;
  VectorXd position_, velocity_;
};

}  // namespace saltus::robots
