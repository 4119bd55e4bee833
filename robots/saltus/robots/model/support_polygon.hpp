// Support polygon: the area of the ground in which the centre of pressure or the capture point may
// lie.
//
// It is the convex hull of foot corners, stored as vertices and as rows a.x <= b with unit outward
// normals. Hence b - a.x is a distance in m.
#pragma once

#include <initializer_list>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus {

/// A point on the ground, m.
using Point2 = Vec<double, 2>;

/// Half planes of a polygon: {x : A x <= b}, where A has unit outward normals (n x 2) and b is in
/// m.
struct HalfPlanes {
  Eigen::Matrix<double, Eigen::Dynamic, 2> A;  ///< rows of unit length
  VectorXd b;                                  ///< right-hand sides, m

  /// Number of rows.
  int rows() const { return static_cast<int>(b.size()); }
};

/// A convex polygon with at least three corners.
class SupportPolygon {
 public:
  /// Convex hull of the points (one per row; m, in any order). Corners within `tolerance` (m) of
  /// the line through their neighbours are dropped. Throws DefinitionError if a coordinate is not
  /// finite or all points lie on one line.
  static SupportPolygon hull(
      const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 2>>& points,
      double tolerance = 1e-9);

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
  Point2 centroid() const;  // of the area, m

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

}  // namespace saltus
