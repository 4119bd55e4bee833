// Where a sole is in the frame of the base, from joint positions alone: what encoders tell.
#pragma once

#include <vector>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus {

/// The chain of joints from the base to one sole. After construction nothing allocates.
class SoleKinematics {
 public:
  /// Of the chain from the base to a sole.
  SoleKinematics(const FloatingRobot& robot, Side side);

  /// For these joint positions, rad.
  void update(const VectorXd& q);

  const Eigen::Isometry3d& pose() const { return pose_; }  ///< of the contact frame
  /// d (position m | rotation rad) / dq, axes of the base; 6 x n.
  const MatrixXd& jacobian() const { return jacobian_; }

 private:
  struct Joint {
    Eigen::Isometry3d origin;
    Vec<double, 3> axis;
    int index;                           // in q
    Vec<double, 3> place, axis_in_base;  // of the last update
  };
  std::vector<Joint> chain_;  // from the base on
  Eigen::Isometry3d end_;     // contact frame in the last body
  Eigen::Isometry3d pose_;
  MatrixXd jacobian_;
};

}  // namespace saltus
