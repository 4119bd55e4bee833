#include "saltus/robots/model/foot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"

namespace saltus::robots {
namespace {

double cross(const Point2& a, const Point2& b) { return a.x() * b.y() - a.y() * b.x(); }

// Signed distance of c to the left of the directed line a -> b.
double left_of(const Point2& a, const Point2& b, const Point2& c) {
  const Point2 edge = b - a;
  const double length = edge.norm();
  return length > 0.0 ? cross(edge, c - a) / length : 0.0;
}

// Andrew's monotone chain: one half of the hull of sorted points, without the last point.
template <class Iterator>
std::vector<Point2> half_hull(Iterator begin, Iterator end) {
  std::vector<Point2> chain;
  for (auto it = begin; it != end; ++it) {
    while (chain.size() >= 2 && left_of(chain[chain.size() - 2], chain.back(), *it) <= 0.0)
      chain.pop_back();
    chain.push_back(*it);
  }
  if (!chain.empty()) chain.pop_back();
  return chain;
}

// Drops, one at a time, the corner nearest to the line through its neighbours while its distance is
// within the tolerance.
void drop_collinear(std::vector<Point2>& v, double tolerance) {
  while (v.size() >= 3) {
    std::size_t flattest = 0;
    double least = tolerance;
    bool found = false;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double height = -left_of(v[(i + v.size() - 1) % v.size()], v[(i + 1) % v.size()], v[i]);
      if (height <= least) {
        least = height;
        flattest = i;
        found = true;
      }
    }
    if (!found) return;
    v.erase(v.begin() + static_cast<std::ptrdiff_t>(flattest));
  }
}

}  // namespace

SupportPolygon SupportPolygon::hull(
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 2>>& points, double tolerance) {
  if (!points.allFinite())
    throw DefinitionError("support polygon: a corner has a coordinate that is not finite");
  if (!(tolerance >= 0.0))
    throw DefinitionError(
        fmt::format("support polygon: the tolerance must not be negative, but is {}", tolerance));
  std::vector<Point2> sorted(points.rows());
  for (int i = 0; i < points.rows(); ++i) sorted[i] = points.row(i).transpose();
  std::sort(sorted.begin(), sorted.end(), [](const Point2& a, const Point2& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Point2> corners = half_hull(sorted.begin(), sorted.end());
  const std::vector<Point2> upper = half_hull(sorted.rbegin(), sorted.rend());
  corners.insert(corners.end(), upper.begin(), upper.end());
  drop_collinear(corners, tolerance);
  if (corners.size() < 3)
    throw DefinitionError(fmt::format(
        "support polygon: {} points on one line do not enclose an area", points.rows()));
  return SupportPolygon(std::move(corners));
}

SupportPolygon SupportPolygon::under(std::initializer_list<PlacedFoot> feet) {
  Eigen::Matrix<double, Eigen::Dynamic, 2> corners(4 * static_cast<int>(feet.size()), 2);
  int row = 0;
  for (const PlacedFoot& foot : feet) {
    corners.middleRows<4>(row) = foot_corners(foot.sole, foot.rectangle);
    row += 4;
  }
  return hull(corners);
}

SupportPolygon::SupportPolygon(std::vector<Point2> vertices) : vertices_(std::move(vertices)) {
  half_planes_.A.resize(size(), 2);
  half_planes_.b.resize(size());
  for (int i = 0; i < size(); ++i) {
    const Point2 edge = (vertices_[(i + 1) % size()] - vertices_[i]).normalized();
    const Point2 outward(edge.y(), -edge.x());
    half_planes_.A.row(i) = outward.transpose();
    half_planes_.b[i] = outward.dot(vertices_[i]);
  }
}

SupportPolygon::HalfPlanes SupportPolygon::half_planes(int n) const {
  if (size() > n)
    throw DefinitionError(fmt::format(
        "support polygon: {} rows were requested, but the polygon has {} edges", n, size()));
  SupportPolygon::HalfPlanes padded;
  padded.A.resize(n, 2);
  padded.b.resize(n);
  for (int i = 0; i < n; ++i) {
    padded.A.row(i) = half_planes_.A.row(i % size());
    padded.b[i] = half_planes_.b[i % size()];
  }
  return padded;
}

double SupportPolygon::area() const {
  double twice = 0.0;
  for (int i = 1; i + 1 < size(); ++i)
    twice += cross(vertices_[i] - vertices_[0], vertices_[i + 1] - vertices_[0]);
  return 0.5 * twice;
}

Point2 SupportPolygon::centroid() const {
  // Mean over a fan of triangles, relative to the first vertex to keep precision far from the
  // origin.
  Point2 moment = Point2::Zero();
  double twice = 0.0;
  for (int i = 1; i + 1 < size(); ++i) {
    const Point2 a = vertices_[i] - vertices_[0];
    const Point2 b = vertices_[i + 1] - vertices_[0];
    moment += cross(a, b) * (a + b) / 3.0;
    twice += cross(a, b);
  }
  return vertices_[0] + moment / twice;
}

double SupportPolygon::signed_distance(const Point2& point) const {
  const double furthest = (half_planes_.A * point - half_planes_.b).maxCoeff();
  if (furthest <= 0.0) return furthest;
  double nearest = infinity;
  for (int i = 0; i < size(); ++i) {
    const Point2& a = vertices_[i];
    const Point2 edge = vertices_[(i + 1) % size()] - a;
    const double along = std::clamp((point - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (point - a - along * edge).norm());
  }
  return nearest;
}

bool SupportPolygon::contains(const Point2& point, double margin) const {
  return (half_planes_.A * point - half_planes_.b).maxCoeff() <= -margin;
}

}  // namespace saltus::robots
