#include "saltus/robots/model/planar_sets.hpp"

#include <algorithm>

namespace saltus::robots {

PlanarPoints weighted_sums(double a, const PlanarPoints& P, double b, const PlanarPoints& Q) {
  PlanarPoints sums(P.rows() * Q.rows(), 2);
  for (Eigen::Index i = 0; i < P.rows(); ++i)
    for (Eigen::Index j = 0; j < Q.rows(); ++j)
      sums.row(i * Q.rows() + j) = a * P.row(i) + b * Q.row(j);
  return sums;
}

double distance_to_border(const SupportPolygon& polygon, const Point2& from, const Point2& along) {
  const SupportPolygon::HalfPlanes& sides = polygon.half_planes();
  double distance = infinity;
  for (int i = 0; i < sides.rows(); ++i) {
    const double speed = sides.A.row(i).dot(along);
    // Sides that the ray does not approach do not limit it.
    if (speed > 0.0) distance = std::min(distance, (sides.b[i] - sides.A.row(i).dot(from)) / speed);
  }
  return distance;
}

}  // namespace saltus::robots
