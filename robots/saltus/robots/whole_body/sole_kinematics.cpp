#include "saltus/robots/whole_body/sole_kinematics.hpp"

#include <algorithm>

namespace saltus::robots {

SoleKinematics::SoleKinematics(const FloatingRobot& robot, Side side)
    : jacobian_(MatrixXd::Zero(6, robot.joints())) {
  const FloatingRobot::Frame& sole = side == Side::left ? robot.left_sole : robot.right_sole;
  end_ = pose_ = sole.pose;
  for (int i = sole.body; i > 0; i = robot.bodies[static_cast<std::size_t>(i)].parent) {
    const FloatingRobot::Body& body = robot.bodies[static_cast<std::size_t>(i)];
    const Vec<double, 3> none = Vec<double, 3>::Zero();  // before the first update
    chain_.push_back({body.origin, body.axis, i - 1, none, none});
  }
  std::reverse(chain_.begin(), chain_.end());
  update(VectorXd::Zero(robot.joints()));
}

void SoleKinematics::update(const VectorXd& q) {
  pose_.setIdentity();
  for (Joint& joint : chain_) {
    pose_ = pose_ * joint.origin;
    joint.place = pose_.translation();
    joint.axis_in_base = pose_.linear() * joint.axis;
    pose_.rotate(Eigen::AngleAxisd(q[joint.index], joint.axis));
  }
  pose_ = pose_ * end_;
  for (const Joint& joint : chain_)
    jacobian_.col(joint.index) << joint.axis_in_base.cross(pose_.translation() - joint.place),
        joint.axis_in_base;
}

}  // namespace saltus::robots
