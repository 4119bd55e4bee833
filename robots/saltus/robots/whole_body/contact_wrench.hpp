// Wrenches of the soles, (force N | torque Nm about the contact frame's origin) in the axes of the
// sole, as forces on the body.
#pragma once

#include "saltus/core/types.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/robots/model/contact_cone.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Matrix from sole axes to (torque | force) in world axes, as in DynamicsModel.
inline Mat<double, 6, 6> wrench_to_world(const DynamicsModel::SoleMotion& sole) {
  Mat<double, 6, 6> world = Mat<double, 6, 6>::Zero();
  world.bottomLeftCorner<3, 3>() = sole.pose.linear();
  world.topRightCorner<3, 3>() = sole.pose.linear();
  return world;
}

/// Matrix from sole axes to (force | torque about the CoM) in world axes.
inline Mat<double, 6, 6> wrench_to_momentum(const DynamicsModel::SoleMotion& sole,
                                            const Vec<double, 3>& com) {
  const Mat<double, 3, 3> R = sole.pose.linear();
  Mat<double, 6, 6> map = Mat<double, 6, 6>::Zero();
  map.topLeftCorner<3, 3>() = R;
  map.bottomLeftCorner<3, 3>() = skew<double>(sole.pose.translation() - com) * R;
  map.bottomRightCorner<3, 3>() = R;
  return map;
}

/// Adds rows that keep the wrench in inputs first, ..., first + 5 within its cone. The group has
/// the capacity of the cone, so nothing allocates.
inline void keep_in_cone(qp::RowGroup& group, const ContactCone& cone, int first) {
  group.rows = cone.rows();
  group.columns.resize(6);
  for (int i = 0; i < 6; ++i) group.columns[i] = first + i;
  group.M = cone.A;
  group.lower.setConstant(-infinity);
  group.upper = cone.b;
}

}  // namespace saltus::robots
