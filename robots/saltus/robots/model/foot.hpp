// Feet: poses of soles, the rectangles of ground that they cover, and the support polygon.
//
// The sole frame has its origin in the contact plane, z pointing away from the ground, x forward
// along the foot. Contact wrenches are expressed in it. The support polygon is the area of the
// ground in which the centre of pressure or the capture point may lie: the convex hull of foot
// corners, stored as vertices and as rows a.x <= b with unit outward normals. Hence b - a.x is a
// distance in m.
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <span>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

// Must follow types.hpp, which defines the error messages of Eigen.
#include <Eigen/Geometry>

namespace saltus::robots {

/// Left or right side of the robot, from the robot's own point of view.
enum class Side { left, right };
/// The opposite side.
inline Side other(Side side) { return side == Side::left ? Side::right : Side::left; }
/// "left" or "right".
inline const char* name_of(Side side) { return side == Side::left ? "left" : "right"; }

/// The part of the sole that touches the ground, in the sole frame, m.
struct FootRectangle {
  Bounds x = between(-0.05, 0.05);  ///< from heel to toe, m
  Bounds y = between(-0.03, 0.03);  ///< from right to left, m

  /// The rectangle of the opposite foot, for a robot that is symmetric about its x-z plane.
  FootRectangle mirrored() const { return {x, between(-y.upper, -y.lower)}; }
  friend bool operator==(const FootRectangle&, const FootRectangle&) = default;
};

/// Pose of a sole frame in the world; S is double for a known foothold, or the scalar of a formula
/// when the foothold is a parameter or an unknown.
template <class S>
struct SoleFrameOf {
  Vec<S, 3> position = Vec<S, 3>(S(0.0), S(0.0), S(0.0));  // origin in the world, m
  Mat<S, 3, 3> rotation = Mat<S, 3, 3>::Identity();        // sole axes -> world axes

  /// Rotates a vector (force, torque, direction) from the axes of the sole to those of the world.
  template <class T>
  Vec<T, 3> to_world(const Vec<T, 3>& in_sole) const {
    // Written entry by entry: the product of Eigen would be compiled for each pair of scalars.
    Vec<T, 3> in_world;
    for (int i = 0; i < 3; ++i)
      in_world[i] =
          rotation(i, 0) * in_sole[0] + (rotation(i, 1) * in_sole[1] + rotation(i, 2) * in_sole[2]);
    return in_world;
  }
};
/// Sole frame with numerical values.
using SoleFrame = SoleFrameOf<double>;

/// Placement of a foot: its sole frame and its rectangle.
struct PlacedFoot {
  SoleFrame sole;           ///< pose of the sole in the world
  FootRectangle rectangle;  ///< sole rectangle, in the sole frame
};

/// Pose of a foot that is flat on level ground. `position` is the origin of its contact frame (m),
/// `yaw` its rotation about the vertical (rad, counter-clockwise from above).
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

/// The corners of foot_corners_3d() projected on the ground (4 x 2, m).
inline Mat<double, 4, 2> foot_corners(const SoleFrame& sole, const FootRectangle& foot) {
  return foot_corners_3d(sole, foot).leftCols<2>();
}

/// A point on the ground, m.
using Point2 = Vec<double, 2>;

/// A convex polygon with at least three corners.
class SupportPolygon {
 public:
  /// Half planes of a polygon: {x : A x <= b}, where A has unit outward normals (n x 2) and b is in
  /// m.
  struct HalfPlanes {
    Eigen::Matrix<double, Eigen::Dynamic, 2> A;  ///< rows of unit length
    VectorXd b;                                  ///< right-hand sides, m

    /// Number of rows.
    int rows() const { return static_cast<int>(b.size()); }
  };

  /// Distance within which a corner is on the line through its neighbours, m.
  static constexpr double collinear = 1e-9;

  /// Convex hull of the points (one per row; m, in any order). Corners within `tolerance` (m) of
  /// the line through their neighbours are dropped. Throws DefinitionError if a coordinate is not
  /// finite or all points lie on one line.
  static SupportPolygon hull(
      const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 2>>& points,
      double tolerance = collinear);

  /// Hull of the corners of the feet on the ground: `under({{left, rectangle}, {right,
  /// rectangle}})`.
  static SupportPolygon under(std::initializer_list<PlacedFoot> feet);

  /// Corners, counter-clockwise, starting at the one with the smallest x (then smallest y).
  const std::vector<Point2>& vertices() const { return vertices_; }
  /// Number of corners.
  int size() const { return static_cast<int>(vertices_.size()); }

  /// One row per edge; row i belongs to the edge from vertex i to vertex i + 1.
  const HalfPlanes& half_planes() const { return half_planes_; }

  /// Exactly n rows, for problems of constant size (the hull of two rectangular feet has at most
  /// 8). The additional rows repeat the first ones: the set does not change, and every row is a
  /// distance with a gradient. (A row "0 <= 1" would be missing in the pattern of the Jacobian.)
  /// Throws DefinitionError if the polygon has more than n edges.
  HalfPlanes half_planes(int n) const;

  double area() const;      // m^2
  Point2 centroid() const;  // centroid of the area, m

  /// Distance to the boundary in m; negative inside, positive outside.
  double signed_distance(const Point2& point) const;
  /// True if the point lies inside, at least `margin` m from the boundary. A negative margin
  /// accepts points outside, measured along the normals.
  bool contains(const Point2& point, double margin = 0.0) const;

 private:
  explicit SupportPolygon(std::vector<Point2> vertices);
  std::vector<Point2> vertices_;
  HalfPlanes half_planes_;
};

/// Support polygon of two feet in a control loop: like `SupportPolygon::under()`, but the
/// constructor neither allocates nor throws.
class SupportOfTwoFeet {
 public:
  static constexpr int rows = 8;  ///< most edges of the hull of two rectangles

  /// Hull of the corners of both feet on the ground.
  SupportOfTwoFeet(const PlacedFoot& one, const PlacedFoot& other);

  /// False if a coordinate is not finite or all corners lie on one line. The other functions must
  /// not be called then.
  bool is_valid() const { return size_ >= 3; }
  /// Unit outward normals A (one per row) and offsets b (m) of {x : A x <= b}. Rows beyond the
  /// number of edges repeat the first ones.
  Mat<double, rows, 2> normals() const;
  Vec<double, rows> offsets() const;  ///< b, m
  Point2 centroid() const;            ///< centroid of the area, m

 private:
  std::span<const Point2> vertices() const { return {vertices_.data(), size_}; }

  std::array<Point2, 2 * rows> vertices_;
  std::size_t size_ = 0;
};

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using Side [[deprecated("use robots::Side; removed in 0.4")]] = robots::Side;
/// Deprecated name.
using FootRectangle [[deprecated("use robots::FootRectangle; removed in 0.4")]] =
    robots::FootRectangle;
/// Deprecated name.
template <class S>
using SoleFrameOf [[deprecated("use robots::SoleFrameOf; removed in 0.4")]] =
    robots::SoleFrameOf<S>;
/// Deprecated name.
using PlacedFoot [[deprecated("use robots::PlacedFoot; removed in 0.4")]] = robots::PlacedFoot;
/// Deprecated name.
using SupportPolygon [[deprecated("use robots::SupportPolygon; removed in 0.4")]] =
    robots::SupportPolygon;
/// Deprecated name.
using SoleFrame [[deprecated("use robots::SoleFrame; removed in 0.4")]] = robots::SoleFrame;
/// Deprecated name.
using Point2 [[deprecated("use robots::Point2; removed in 0.4")]] = robots::Point2;
/// Deprecated name.
using HalfPlanes [[deprecated("use robots::SupportPolygon::HalfPlanes; removed in 0.4")]] =
    robots::SupportPolygon::HalfPlanes;
using robots::flat_sole;        ///< deprecated name
using robots::foot_corners;     ///< deprecated name
using robots::foot_corners_3d;  ///< deprecated name
using robots::name_of;          ///< deprecated name
using robots::other;            ///< deprecated name
}  // namespace saltus

namespace saltus::robots::walking {}
namespace saltus {
namespace walking = robots::walking;  ///< deprecated name, removed in 0.4
}  // namespace saltus
