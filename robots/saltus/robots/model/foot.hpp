// Where does a foot stand, and which rectangle of ground does it cover?
//
// The sole frame has its origin in the contact plane, z pointing away from the ground, x forward
// along the foot. Contact wrenches are expressed in it.
#pragma once

#include <cmath>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

// After types.hpp, which words the errors of Eigen.
#include <Eigen/Geometry>

namespace saltus {

/// Of the robot, seen by itself.
enum class Side { left, right };
/// The other one.
inline Side other(Side side) { return side == Side::left ? Side::right : Side::left; }
/// "left" or "right".
inline const char* name_of(Side side) { return side == Side::left ? "left" : "right"; }

/// The part of the sole that touches the ground, in the sole frame, m.
struct FootRectangle {
  Bounds x = between(-0.05, 0.05);  ///< from heel to toe, m
  Bounds y = between(-0.03, 0.03);  ///< from right to left, m

  /// The other foot of a robot that is symmetric about its x-z plane.
  FootRectangle mirrored() const { return {x, between(-y.upper, -y.lower)}; }
  friend bool operator==(const FootRectangle&, const FootRectangle&) = default;
};

/// Pose of a sole frame in the world; S is double for a known foothold, or the scalar of a formula
/// when the foothold is a parameter or an unknown.
template <class S>
struct SoleFrameOf {
  Vec<S, 3> position = Vec<S, 3>(S(0.0), S(0.0), S(0.0));  // of the origin, in the world, m
  Mat<S, 3, 3> rotation = Mat<S, 3, 3>::Identity();        // sole axes -> world axes

  /// A vector given in the sole's axes (force, torque, direction), in the world's axes.
  template <class T>
  Vec<T, 3> to_world(const Vec<T, 3>& in_sole) const {
    // Entry by entry: Eigen's product would be compiled for each pair of scalars.
    Vec<T, 3> in_world;
    for (int i = 0; i < 3; ++i)
      in_world[i] =
          rotation(i, 0) * in_sole[0] + (rotation(i, 1) * in_sole[1] + rotation(i, 2) * in_sole[2]);
    return in_world;
  }
};
/// In numbers.
using SoleFrame = SoleFrameOf<double>;

/// A foot that stands somewhere.
struct PlacedFoot {
  SoleFrame sole;           ///< where it stands
  FootRectangle rectangle;  ///< its sole, in that frame
};

/// A foot flat on level ground: position of its contact frame (m) and yaw about the vertical (rad,
/// counter-clockwise from above).
inline SoleFrame flat_sole(const Vec<double, 3>& position, double yaw = 0.0) {
  SoleFrame sole;
  sole.position = position;
  if (yaw != 0.0) {
    sole.rotation(0, 0) = std::cos(yaw);
    sole.rotation(0, 1) = -std::sin(yaw);
    sole.rotation(1, 0) = std::sin(yaw);
    sole.rotation(1, 1) = std::cos(yaw);
  }
  return sole;
}

/// The four corners in the world (rows; m), counter-clockwise seen from above for a flat foot:
/// (x max, y max), (x min, y max), (x min, y min), (x max, y min).
inline Mat<double, 4, 3> foot_corners_3d(const SoleFrame& sole, const FootRectangle& foot) {
  const double x[4] = {foot.x.upper, foot.x.lower, foot.x.lower, foot.x.upper};
  const double y[4] = {foot.y.upper, foot.y.upper, foot.y.lower, foot.y.lower};
  Mat<double, 4, 3> corners;
  for (int i = 0; i < 4; ++i) {
    const Vec<double, 3> in_sole(x[i], y[i], 0.0);
    corners.row(i) = (sole.position + sole.rotation * in_sole).transpose();
  }
  return corners;
}

/// The same corners projected on the ground (4 x 2).
inline Mat<double, 4, 2> foot_corners(const SoleFrame& sole, const FootRectangle& foot) {
  return foot_corners_3d(sole, foot).leftCols<2>();
}

}  // namespace saltus
