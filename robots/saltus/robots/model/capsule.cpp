// Closest points of segments: Ericson, Real-Time Collision Detection, 2005, 5.1.9. Fit: the radius
// and the ends of the smallest capsule about a given line have a closed form. The line is found by
// a pattern search that starts from the principal axes.
#include "saltus/robots/model/capsule.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"

namespace saltus::robots {
namespace {

using Point = Vec<double, 3>;
using Points = std::vector<Point>;

constexpr int directions = 100;  // number of directions in which extreme points are searched
// a cut is kept if it reduces the volume to this fraction or less
constexpr double worth_cutting = 0.75;
constexpr double too_small = 0.025;  // m; clouds with a smaller radius are not cut
constexpr double overlap = 0.1;      // overlap of the two parts of a cut, relative to the length
constexpr double finest = 1e-4;      // rad and m: resolution of the search

// The points that are extreme in one of many directions: nearly the corners of the convex hull.
Points extreme_points(const Points& points) {
  std::vector<std::size_t> kept;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  // spiral over half the sphere; each direction gives both extremes
  for (int i = 0; i < directions; ++i) {
    const double z = (i + 0.5) / directions, r = std::sqrt(1.0 - z * z);
    const Point d(r * std::cos(golden * i), r * std::sin(golden * i), z);
    std::size_t least = 0, largest = 0;
    double low = infinity, high = -infinity;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double s = d.dot(points[k]);
      if (s < low) low = s, least = k;
      if (s > high) high = s, largest = k;
    }
    kept.push_back(least);
    kept.push_back(largest);
  }
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  Points result;
  for (const std::size_t k : kept) result.push_back(points[k]);
  return result;
}

// The smallest capsule that encloses the points and has its axis on the line through `centre` along
// `axis`.
Capsule around(const Points& points, const Point& centre, const Point& axis) {
  Capsule capsule;
  for (const Point& p : points)
    capsule.radius = std::max(capsule.radius, (p - centre).cross(axis).norm());
  double from = infinity, to = -infinity;
  for (const Point& p : points) {
    const double s = axis.dot(p - centre), across = (p - centre).cross(axis).norm();
    const double cap =
        std::sqrt(std::max(0.0, (capsule.radius - across) * (capsule.radius + across)));
    from = std::min(from, s + cap);
    to = std::max(to, s - cap);
  }
  if (from > to) from = to = 0.5 * (from + to);
  capsule.from = centre + from * axis;
  capsule.to = centre + to * axis;
  if (from == to)
    for (const Point& p : points)
      capsule.radius = std::max(capsule.radius, (p - capsule.to).norm());
  return capsule;
}

// Principal axes in columns, in the order of ascending spread.
Mat<double, 3, 3> principal_axes(const Points& points, const Point& mean) {
  Mat<double, 3, 3> spread = Mat<double, 3, 3>::Zero();
  for (const Point& p : points) spread += (p - mean) * (p - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Mat<double, 3, 3>>(spread).eigenvectors();
}

Point middle_of(const Points& points) {
  Point low = points.front(), high = low;
  for (const Point& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return 0.5 * (low + high);
}

// Rotates and shifts the line while the volume decreases.
Capsule improved(const Points& points, Point centre, Point axis) {
  Capsule best = around(points, centre, axis);
  double size = 0.0;
  for (const Point& p : points) size = std::max(size, (p - centre).norm());
  for (double step = 0.2; step > finest; step *= 0.5) {
    for (bool falls = true; falls;) {
      falls = false;
      const Point u = axis.unitOrthogonal(), v = axis.cross(u);
      for (const Point& d : std::array<Point, 4>{u, -u, v, -v}) {
        const Point turned = (axis + step * d).normalized(), shifted = centre + step * size * d;
        const Capsule turn = around(points, centre, turned), shift = around(points, shifted, axis);
        if (turn.volume() < best.volume()) {
          best = turn;
          axis = turned;
          falls = true;
          break;
        }
        if (shift.volume() < best.volume()) {
          best = shift;
          centre = shifted;
          falls = true;
          break;
        }
      }
    }
  }
  return best;
}

// The smallest of the capsules about the principal axes, as the start of the search.
Capsule rough_capsule(const Points& points) {
  const Point middle = middle_of(points);
  const Mat<double, 3, 3> axes = principal_axes(points, middle);
  Capsule best = around(points, middle, axes.col(2));
  for (const int i : {0, 1}) {
    const Capsule other = around(points, middle, axes.col(i));
    if (other.volume() < best.volume()) best = other;
  }
  return best;
}

Capsule least_capsule(const Points& all) {
  const Points points = extreme_points(all);
  const Point middle = middle_of(points);
  const Mat<double, 3, 3> axes = principal_axes(points, middle);
  Capsule best = improved(points, middle, axes.col(2));
  for (const int i : {0, 1}) {
    const Capsule other = improved(points, middle, axes.col(i));
    if (other.volume() < best.volume()) best = other;
  }
  // Include the points between the searched directions.
  for (const Point& p : all)
    best.radius = std::max(best.radius, (closest_points(best, {p, p, 0.0}).first - p).norm());
  return best;
}

// A part of the cloud and the capsule that contains it.
struct Part {
  Points points;
  Capsule capsule;
};

// The cut across a principal axis that gives the smallest rough capsules.
std::array<Part, 2> cut_in_two(const Points& points) {
  const Mat<double, 3, 3> axes = principal_axes(points, middle_of(points));
  std::array<Part, 2> best;
  double least = infinity;
  for (int i = 0; i < 3; ++i) {
    double low = infinity, high = -infinity;
    for (const Point& p : points) {
      low = std::min(low, axes.col(i).dot(p));
      high = std::max(high, axes.col(i).dot(p));
    }
    for (const double fraction : {0.3, 0.5, 0.7}) {
      const double at = low + fraction * (high - low), more = 0.5 * overlap * (high - low);
      std::array<Part, 2> parts;
      for (const Point& p : points) {
        const double s = axes.col(i).dot(p);
        if (s <= at + more) parts[0].points.push_back(p);
        if (s >= at - more) parts[1].points.push_back(p);
      }
      double volume = 0.0;
      for (const Part& part : parts) volume += rough_capsule(extreme_points(part.points)).volume();
      if (volume >= least) continue;
      least = volume;
      best = std::move(parts);
    }
  }
  for (Part& part : best) part.capsule = least_capsule(part.points);
  return best;
}

// Cuts the part whose cut saves the most volume in two, if it saves enough.
bool cut_one(std::vector<Part>& parts) {
  double least = worth_cutting;
  std::size_t which = parts.size();
  std::array<Part, 2> halves;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].capsule.radius < too_small) continue;
    std::array<Part, 2> cut = cut_in_two(parts[i].points);
    const double ratio =
        (cut[0].capsule.volume() + cut[1].capsule.volume()) / parts[i].capsule.volume();
    if (!(ratio < least)) continue;
    least = ratio;
    which = i;
    halves = std::move(cut);
  }
  if (which == parts.size()) return false;
  parts[which] = std::move(halves[0]);
  parts.push_back(std::move(halves[1]));
  return true;
}

}  // namespace

double Capsule::volume() const {
  return std::numbers::pi * radius * radius * (length() + 4.0 / 3.0 * radius);
}

Capsule operator*(const Eigen::Isometry3d& pose, const Capsule& capsule) {
  return {pose * capsule.from, pose * capsule.to, capsule.radius};
}

SegmentPoints closest_points(const Capsule& first, const Capsule& second) {
  const Point d1 = first.to - first.from, d2 = second.to - second.from;
  const Point r = first.from - second.from;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r);
  const auto share = [](double x) { return std::clamp(x, 0.0, 1.0); };
  double s = 0.0, t = 0.0;  // parameters along the first and the second segment
  if (a > 0.0 && e > 0.0) {
    const double b = d1.dot(d2), c = d1.dot(r);
    const double determinant = a * e - b * b;
    constexpr double parallel = 1e-12;  // relative rounding error of the products
    if (determinant > parallel * a * e) s = share((b * f - c * e) / determinant);
    t = (b * s + f) / e;
    if (t < 0.0 || t > 1.0) {
      t = share(t);
      s = share((b * t - c) / a);
    }
  } else if (a > 0.0) {
    s = share(-d1.dot(r) / a);
  } else if (e > 0.0) {
    t = share(f / e);
  }
  return {first.from + s * d1, second.from + t * d2};
}

std::vector<Capsule> fit_capsules(const std::vector<Point>& points, int most) {
  if (points.empty()) throw DefinitionError("fitting capsules needs at least one point");
  std::vector<Part> parts{{points, least_capsule(points)}};
  while (static_cast<int>(parts.size()) < most && cut_one(parts)) {
  }
  std::vector<Capsule> capsules;
  constexpr double thinnest = 1e-3;  // m: simulators reject shapes without extent
  for (Part& part : parts) {
    part.capsule.radius = std::max(part.capsule.radius, thinnest);
    capsules.push_back(part.capsule);
  }
  return capsules;
}

}  // namespace saltus::robots
