// Where the whole robot is and how fast it moves.
#pragma once

#include <Eigen/Geometry>

#include "saltus/core/types.hpp"

namespace saltus {

/// Positions and velocities of a FloatingRobot, joints in its order.
struct WholeBodyState {
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< pose of the base in the world
  Vec<double, 6> base_twist = Vec<double, 6>::Zero();      ///< (angular rad/s | linear m/s of the
                                                           ///< base's origin), world axes
  VectorXd q;                                              ///< rad
  VectorXd dq;                                             ///< rad/s

  /// Whether every number is finite.
  bool is_finite() const {
    return base.matrix().allFinite() && base_twist.allFinite() && q.allFinite() && dq.allFinite();
  }
};

}  // namespace saltus
