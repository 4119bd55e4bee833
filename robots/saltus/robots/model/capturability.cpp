#include "saltus/robots/model/capturability.hpp"

#include <cmath>

namespace saltus::robots {
namespace {

PlanarPoints vertices(const SupportPolygon& polygon) {
  PlanarPoints points(polygon.size(), 2);
  for (int i = 0; i < polygon.size(); ++i) points.row(i) = polygon.vertices()[i].transpose();
  return points;
}

PlanarPoints together(const PlanarPoints& P, const PlanarPoints& Q) {
  PlanarPoints points(P.rows() + Q.rows(), 2);
  points << P, Q;
  return points;
}

// Reachable places, in the contact frame of the stance foot.
PlanarPoints places(const SteppingLimits& limits, Side stance) {
  const double away = stance == Side::left ? -1.0 : 1.0;
  PlanarPoints points(static_cast<Eigen::Index>(limits.reach.size()), 2);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Point2& place = limits.reach[static_cast<std::size_t>(i)];
    points.row(i) << place[0], away * place[1];
  }
  return points;
}

PlanarPoints sole(const SteppingLimits& limits, Side side) {
  const FootRectangle& foot = side == Side::left ? limits.left : limits.right;
  return corners_of(foot.x, foot.y);
}

}  // namespace

PlanarPoints corners_of(const Bounds& x, const Bounds& y) {
  PlanarPoints points(4, 2);
  points << x.upper, y.upper, x.lower, y.upper, x.lower, y.lower, x.upper, y.lower;
  return points;
}

SupportPolygon capturable(const SteppingLimits& limits, Side stance, int steps, double omega) {
  const PlanarPoints S = sole(limits, stance);
  if (steps <= 0) return SupportPolygon::hull(S);
  const PlanarPoints next = vertices(capturable(limits, other(stance), steps - 1, omega));
  const double e = std::exp(-omega * limits.shortest);
  return SupportPolygon::hull(weighted_sums(
      1.0 - e, S, e, together(S, weighted_sums(1.0, places(limits, stance), 1.0, next))));
}

std::vector<SupportPolygon> capturable_on_two_feet(const SteppingLimits& limits,
                                                   const Point2& right, int steps, double omega) {
  const auto moved = [&right](PlanarPoints points) {
    points.rowwise() += right.transpose();
    return points;
  };
  const PlanarPoints both = together(sole(limits, Side::left), moved(sole(limits, Side::right)));
  if (steps <= 0) return {SupportPolygon::hull(both)};
  const PlanarPoints on_left = vertices(capturable(limits, Side::left, steps, omega)),
                     on_right = vertices(capturable(limits, Side::right, steps, omega));
  return {SupportPolygon::hull(together(both, on_left)),
          SupportPolygon::hull(together(both, moved(on_right)))};
}

}  // namespace saltus::robots
