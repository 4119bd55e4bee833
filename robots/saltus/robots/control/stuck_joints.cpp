#include "saltus/robots/control/stuck_joints.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus::robots::control {

StuckJoints::StuckJoints(VectorXd effort, Options options)
    : effort_(std::move(effort)), options_(options) {
  from_ = still_ = gained_ = pushed_ = VectorXd::Zero(effort_.size());
}

void StuckJoints::start(const VectorXd& q) {
  from_ = q;
  for (VectorXd* part : {&still_, &gained_, &pushed_}) part->setZero();
}

Eigen::Index StuckJoints::update(double dt, const VectorXd& q, const VectorXd& dq,
                                 const Robot::Commands& c, const VectorXd* accelerations) {
  if (options_.time <= 0.0) return -1;
  Eigen::Index stuck = -1;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (std::abs(q[i] - from_[i]) > options_.motion) {
      from_[i] = q[i];
      still_[i] = gained_[i] = pushed_[i] = 0.0;
      continue;
    }
    still_[i] += dt;
    bool is_driven = false;
    if (accelerations != nullptr) {
      gained_[i] += dt * (*accelerations)[i];
      is_driven = std::abs(gained_[i]) > options_.speed;
      if (still_[i] >= options_.time) worst_ = std::max(worst_, std::abs(gained_[i]));
    } else {
      const double torque = c.torques[i] + c.stiffness[i] * (c.positions[i] - q[i]) +
                            c.damping[i] * (c.velocities[i] - dq[i]);
      pushed_[i] = std::abs(torque) >= options_.torque * effort_[i] ? pushed_[i] + dt : 0.0;
      is_driven = pushed_[i] >= options_.time;
    }
    if (is_driven && still_[i] >= options_.time) stuck = i;
  }
  return stuck;
}

}  // namespace saltus::robots::control
