// State of the whole robot, and the forces on its feet.
#pragma once

#include <Eigen/Geometry>

#include "saltus/core/types.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus {

/// Positions and velocities of a FloatingRobot, joints in its order.
struct WholeBodyState {
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< pose of the base in the world
  Vec<double, 6> base_twist = Vec<double, 6>::Zero();      ///< (angular rad/s | linear m/s of the
                                                           ///< base's origin), world axes
  VectorXd q;                                              ///< rad
  VectorXd dq;                                             ///< rad/s

  /// True if every number is finite.
  bool is_finite() const {
    return base.matrix().allFinite() && base_twist.allFinite() && q.allFinite() && dq.allFinite();
  }
};

/// Force of the ground on a foot.
struct FootContact {
  bool touches = false;                            ///< True if forces act.
  Vec<double, 6> wrench = Vec<double, 6>::Zero();  ///< (force N | torque Nm about the origin of the
                                                   ///< contact frame), world axes
};

/// State and contacts, either measured by ideal sensors or estimated.
struct WholeBodyEstimate {
  WholeBodyState state;     ///< state of base and joints
  FootContact left, right;  ///< contacts of both feet

  /// Contact of one foot.
  const FootContact& contact(Side side) const { return side == Side::left ? left : right; }
};

}  // namespace saltus
