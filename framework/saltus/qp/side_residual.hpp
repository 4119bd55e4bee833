// What one row or bound adds to a KKT residual: its violation, and its multiplier against its
// sides.
#pragma once

#include <algorithm>
#include <cmath>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// worst = max(worst, |value|), where NaN counts as infinite: a residual is never flattered by it.
inline void raise(double& worst, double value) {
  const double size = std::abs(value);
  if (!(size <= worst)) worst = std::isnan(size) ? infinity : size;
}

/// The largest magnitude in v, likewise.
inline double largest_entry(const Eigen::Ref<const VectorXd>& v) {
  double worst = 0.0;
  for (const double x : v) raise(worst, x);
  return worst;
}

/// Raises both parts for a hard row (or variable) of this value between its sides. A multiplier
/// must push against the side that holds: positive at the upper, negative at the lower one; its
/// product with the distance to that side must vanish. Where the sides are equal it is free.
inline void add_hard(double value, double lower, double upper, double multiplier,
                     double& feasibility, double& complementarity) {
  if (!(value >= lower)) raise(feasibility, lower - value);
  if (!(value <= upper)) raise(feasibility, value - upper);
  if (lower == upper || multiplier == 0.0) return;
  const double distance = multiplier > 0.0 ? upper - value : value - lower;
  // Without a side there it pushes against nothing, and counts as it is.
  raise(complementarity,
        std::isfinite(distance) ? multiplier * std::max(distance, 0.0) : multiplier);
}

/// The same for a soft row. A side missed by t >= 0 costs l1 t + l2/2 t^2; optimal are
/// 0 <= multiplier <= l1 + l2 t, equal to the upper limit if t > 0, zero if the side is not
/// reached.
///
/// t is what the value implies, with one freedom: a multiplier above its limit by e is an error e
/// of stationarity in t, or, as the limit rises with t, an error multiplier x e / l2 of
/// complementarity at the t that permits it. The smaller counts, as it would with t among the
/// variables.
inline void add_soft(double value, double lower, double upper, double l1, double l2,
                     double multiplier, double& stationarity, double& complementarity) {
  const auto add_side = [&](double miss, double m) {
    if (miss == -infinity) return raise(complementarity, m);
    const double t = std::max(miss, 0.0);
    const double gap = l1 + l2 * t - m;
    if (gap >= 0.0) {
      raise(complementarity, t * gap);
    } else if (l2 > 0.0 && m < l2) {
      raise(complementarity, m * gap / l2);
    } else {
      raise(stationarity, gap);
    }
    raise(complementarity, m * std::max(-miss, 0.0));
  };
  add_side(value - upper, std::max(multiplier, 0.0));
  add_side(lower - value, std::max(-multiplier, 0.0));
}

}  // namespace saltus
