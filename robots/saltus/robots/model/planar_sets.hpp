// Sums of planar convex sets and the length of rays inside one, used to bound the reach of capture
// points.
#pragma once

#include "saltus/robots/model/foot.hpp"

namespace saltus::robots {

using PlanarPoints = Eigen::Matrix<double, Eigen::Dynamic, 2>;  // one point per row, m

/// All sums a p + b q with p from P and q from Q. Their hull is the weighted Minkowski sum of the
/// hulls of P and Q.
PlanarPoints weighted_sums(double a, const PlanarPoints& P, double b, const PlanarPoints& Q);

/// Distance (m) from the inner point `from` (m) along the unit vector `along` to the border of the
/// polygon.
double distance_to_border(const SupportPolygon& polygon, const Point2& from, const Point2& along);

}  // namespace saltus::robots
