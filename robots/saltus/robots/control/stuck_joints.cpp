#include "saltus/robots/control/stuck_joints.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus::robots::control {

StuckJoints::StuckJoints(VectorXd effort, Options options)
    : effort_(std::move(effort)), options_(options) {
  from_ = still_ = at_limit_ = sum_ = VectorXd::Zero(effort_.size());
  for (VectorXd& mean : means_) mean = sum_;
}

void StuckJoints::start(const VectorXd& q) {
  from_ = q;
  for (VectorXd* part : {&still_, &at_limit_, &sum_}) part->setZero();
  third_ = 0.0;
}

Eigen::Index StuckJoints::update(double dt, const VectorXd& q, const VectorXd& dq,
                                 const Robot::Commands& c) {
  if (options_.time <= 0.0) return -1;
  Eigen::Index stuck = -1;
  third_ += dt;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double torque = c.torques[i] + c.stiffness[i] * (c.positions[i] - q[i]) +
                          c.damping[i] * (c.velocities[i] - dq[i]);
    sum_[i] += dt * torque;
    at_limit_[i] = std::abs(torque) >= options_.limit * effort_[i] ? at_limit_[i] + dt : 0.0;
    still_[i] += dt;
    if (std::abs(q[i] - from_[i]) > options_.motion) {
      from_[i] = q[i];
      still_[i] = 0.0;
    }
    if (std::min(still_[i], at_limit_[i]) >= options_.time) stuck = i;
  }
  if (third_ < options_.time / 3.0) return stuck;
  means_[0].swap(means_[1]);
  means_[1].swap(means_[2]);
  means_[2] = sum_ / third_;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (still_[i] < options_.time) continue;
    const double change = std::abs(0.5 * (means_[1][i] + means_[2][i]) - means_[0][i]) / effort_[i];
    worst_ = std::max(worst_, change);
    if (change >= options_.change) stuck = i;
  }
  sum_.setZero();
  third_ = 0.0;
  return stuck;
}

}  // namespace saltus::robots::control
