// Sums of convex sets in the plane and how far a ray runs inside one: what bounds on the reach of
// capture points are made of.
#pragma once

#include "saltus/robots/model/support_polygon.hpp"

namespace saltus {

using PlanarPoints = Eigen::Matrix<double, Eigen::Dynamic, 2>;  // a point per row, m

/// All sums a p + b q of a p from P and a q from Q; their hull is the weighted Minkowski sum of the
/// hulls of P and Q.
PlanarPoints weighted_sums(double a, const PlanarPoints& P, double b, const PlanarPoints& Q);

/// How far from `from` (inside, m) along `along` (unit vector) the polygon ends, m.
double distance_to_border(const SupportPolygon& polygon, const Point2& from, const Point2& along);

}  // namespace saltus
