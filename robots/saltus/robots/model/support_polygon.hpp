// Inside which polygon on the ground may the centre of pressure (or the capture point) lie?
//
// The convex hull of foot corners, as vertices and as rows a.x <= b with unit outward normals, so
// that b - a.x is a distance in m.
#pragma once

#include <initializer_list>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus {

/// A point of the ground, m.
using Point2 = Vec<double, 2>;

/// Rows of a polygon: {x : A x <= b}, A of unit outward normals (n x 2), b in m.
struct HalfPlanes {
  Eigen::Matrix<double, Eigen::Dynamic, 2> A;  ///< rows of unit length
  VectorXd b;                                  ///< in m: A p <= b

  /// How many.
  int rows() const { return static_cast<int>(b.size()); }
};

/// A convex polygon with at least three corners.
class SupportPolygon {
 public:
  /// Convex hull of the points (rows; m), in any order. Corners within `tolerance` (m) of the line
  /// through their neighbours are dropped. Throws DefinitionError when a coordinate is not finite
  /// or all points lie on one line.
  static SupportPolygon hull(
      const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 2>>& points,
      double tolerance = 1e-9);

  /// Hull of the corners of feet on the ground: `under({{left, rectangle}, {right, rectangle}})`.
  static SupportPolygon under(std::initializer_list<PlacedFoot> feet);

  /// Corners, counter-clockwise, starting at the one with the least x (then least y).
  const std::vector<Point2>& vertices() const { return vertices_; }
  /// How many corners.
  int size() const { return static_cast<int>(vertices_.size()); }

  /// One row per edge; row i belongs to the edge from vertex i to vertex i + 1.
  const HalfPlanes& half_planes() const { return half_planes_; }

  /// Exactly n rows, for problems of constant size (the hull of two rectangular feet has at most
  /// 8). The rows beyond size() repeat the rows from the first on: the set stays the same, and
  /// every row is a meaningful distance with a gradient (a row "0 <= 1" would be empty in the
  /// Jacobian's pattern). Throws DefinitionError when the polygon has more than n edges.
  HalfPlanes half_planes(int n) const;

  double area() const;      // m^2
  Point2 centroid() const;  // of the area, m

  /// Distance to the boundary in m: negative inside, positive outside.
  double signed_distance(const Point2& point) const;
  /// Whether the point lies inside, at least `margin` m from the boundary (negative: tolerated
  /// outside, measured along the normals).
  bool contains(const Point2& point, double margin = 0.0) const;

 private:
  explicit SupportPolygon(std::vector<Point2> vertices);
  std::vector<Point2> vertices_;
  HalfPlanes half_planes_;
};

}  // namespace saltus
