// The iterate of the interior-point method and its step, as flat arrays.
#pragma once

#include "saltus/qp/lanes.hpp"

namespace saltus::qp {

/// Sides G v + t - s = beta with s, lambda > 0, and t, tau > 0 on soft sides. Padding lanes hold
/// s = t = tau = 1 and lambda = 0 and never move.
struct Iterate {
  Iterate(int variables, int equalities, int sides)
      : v(variables), y(equalities), s(sides), lambda(sides), t(sides), tau(sides) {}
  AlignedArray v, y, s, lambda, t, tau;
};

/// Residuals of the optimality conditions at an iterate.
struct Residuals {
  Residuals(int variables, int equalities, int sides)
      : stationarity(variables), equality(equalities), side(sides), soft(sides) {}
  AlignedArray stationarity;  ///< H v + g + E'y - G'lambda
  AlignedArray equality;      ///< E v - e
  AlignedArray side;          ///< G v + t - s - beta
  AlignedArray soft;          ///< l1 + l2 t - lambda - tau
  double mu = 0.0;            ///< mean product s lambda and t tau
  double largest_product = 0.0;
  double largest = 0.0;      ///< largest entry of all of the above
  double feasibility = 0.0;  ///< largest violation in equality and side
};

/// Product changes that a step aims at, divided by s (or t): see ipm_corrector.hpp.
struct SideTarget {
  explicit SideTarget(int sides) : side(sides), soft(sides) {}
  AlignedArray side, soft;
};

}  // namespace saltus::qp
