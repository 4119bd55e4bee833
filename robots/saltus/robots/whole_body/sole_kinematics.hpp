// Leg kinematics: pose of a sole in the frame of the base, from joint positions alone.
#pragma once

#include <vector>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// The chain of joints from the base to one sole. Does not allocate after construction.
class SoleKinematics {
 public:
  /// Builds the chain of the given side.
  SoleKinematics(const FloatingRobot& robot, Side side);

  /// Computes pose and Jacobian at these joint positions, rad.
  void update(const VectorXd& q);

  const Eigen::Isometry3d& pose() const { return pose_; }  ///< contact frame in the base
  /// d (position m | rotation rad) / dq, axes of the base; 6 x n.
  const MatrixXd& jacobian() const { return jacobian_; }

 private:
  struct Joint {
    Eigen::Isometry3d origin;
    Vec<double, 3> axis;
    int index;                           // index in q
    Vec<double, 3> place, axis_in_base;  // values at the last update
  };
  std::vector<Joint> chain_;  // joints in the order from the base to the sole
  Eigen::Isometry3d end_;     // contact frame in the last body
  Eigen::Isometry3d pose_;
  MatrixXd jacobian_;
};

}  // namespace saltus::robots
