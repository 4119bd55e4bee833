#include "saltus/robots/model/foot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

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

// Andrew's monotone chain: writes one half of the hull of sorted points to `chain` and returns its
// number of points, without the last one.
template <class Iterator>
std::size_t half_hull(Iterator begin, Iterator end, std::span<Point2> chain) {
  std::size_t size = 0;
  for (auto it = begin; it != end; ++it) {
    while (size >= 2 && left_of(chain[size - 2], chain[size - 1], *it) <= 0.0) --size;
    chain[size++] = *it;
  }
  return size > 0 ? size - 1 : 0;
}

// Drops, one at a time, the corner nearest to the line through its neighbours while its distance is
// within the tolerance. Returns the number of corners that remain.
std::size_t drop_collinear(std::span<Point2> v, double tolerance) {
  std::size_t size = v.size();
  while (size >= 3) {
    std::size_t flattest = 0;
    double least = tolerance;
    bool found = false;
    for (std::size_t i = 0; i < size; ++i) {
      const double height = -left_of(v[(i + size - 1) % size], v[(i + 1) % size], v[i]);
      if (height <= least) {
        least = height;
        flattest = i;
        found = true;
      }
    }
    if (!found) break;
    const auto dropped = v.begin() + static_cast<std::ptrdiff_t>(flattest);
    std::copy(dropped + 1, v.begin() + static_cast<std::ptrdiff_t>(size), dropped);
    --size;
  }
  return size;
}

// Sorts the points and writes the corners of their hull, which needs room for twice as many points.
// Returns the number of corners, less than 3 if the points lie on one line.
std::size_t find_corners(std::span<Point2> points, std::span<Point2> corners, double tolerance) {
  std::sort(points.begin(), points.end(), [](const Point2& a, const Point2& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::size_t size = half_hull(points.begin(), points.end(), corners);
  size += half_hull(points.rbegin(), points.rend(), corners.subspan(size));
  return drop_collinear(corners.first(size), tolerance);
}

// Unit outward normal of the edge from vertex i to the next one.
Point2 normal_of(std::span<const Point2> vertices, std::size_t i) {
  const Point2 edge = (vertices[(i + 1) % vertices.size()] - vertices[i]).normalized();
  return {edge.y(), -edge.x()};
}

// Centroid of the area: mean over a fan of triangles, relative to the first vertex to keep
// precision far from the origin.
Point2 centroid_of(std::span<const Point2> vertices) {
  Point2 moment = Point2::Zero();
  double twice = 0.0;
  for (std::size_t i = 1; i + 1 < vertices.size(); ++i) {
    const Point2 a = vertices[i] - vertices[0];
    const Point2 b = vertices[i + 1] - vertices[0];
    moment += cross(a, b) * (a + b) / 3.0;
    twice += cross(a, b);
  }
  return vertices[0] + moment / twice;
}

}  // namespace

SupportPolygon SupportPolygon::hull(
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 2>>& points, double tolerance) {
  if (!points.allFinite())
    throw DefinitionError("support polygon: a corner has a coordinate that is not finite");
  if (!(tolerance >= 0.0))
    throw DefinitionError(
        fmt::format("support polygon: the tolerance must not be negative, but is {}", tolerance));
  const auto n = static_cast<std::size_t>(points.rows());
  std::vector<Point2> sorted(n), corners(2 * n);
  for (std::size_t i = 0; i < n; ++i)
    sorted[i] = points.row(static_cast<Eigen::Index>(i)).transpose();
  corners.resize(find_corners(sorted, corners, tolerance));
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
    const Point2 outward = normal_of(vertices_, static_cast<std::size_t>(i));
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

Point2 SupportPolygon::centroid() const { return centroid_of(vertices_); }

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

SupportOfTwoFeet::SupportOfTwoFeet(const PlacedFoot& one, const PlacedFoot& other) {
  const Mat<double, 4, 2> corners[] = {foot_corners(one.sole, one.rectangle),
                                       foot_corners(other.sole, other.rectangle)};
  std::array<Point2, rows> points;
  for (int i = 0; i < rows; ++i)
    points[static_cast<std::size_t>(i)] = corners[i / 4].row(i % 4).transpose();
  if (!corners[0].allFinite() || !corners[1].allFinite()) return;
  size_ = find_corners(points, vertices_, SupportPolygon::collinear);
}

Mat<double, SupportOfTwoFeet::rows, 2> SupportOfTwoFeet::normals() const {
  Mat<double, rows, 2> result;
  for (std::size_t i = 0; i < rows; ++i)
    result.row(static_cast<Eigen::Index>(i)) = normal_of(vertices(), i % size_).transpose();
  return result;
}

Vec<double, SupportOfTwoFeet::rows> SupportOfTwoFeet::offsets() const {
  Vec<double, rows> result;
  for (std::size_t i = 0; i < rows; ++i)
    result[static_cast<Eigen::Index>(i)] =
        normal_of(vertices(), i % size_).dot(vertices_[i % size_]);
  return result;
}

Point2 SupportOfTwoFeet::centroid() const { return centroid_of(vertices()); }

}  // namespace saltus::robots
