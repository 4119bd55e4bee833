// Contribution of one row or bound to a KKT residual: its violation and its complementarity.
#pragma once

#include <algorithm>
#include <cmath>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// Sets worst = max(worst, |value|). NaN counts as infinite, so that it never improves a residual.
inline void raise(double& worst, double value) {
  const double size = std::abs(value);
  if (!(size <= worst)) worst = std::isnan(size) ? infinity : size;
}

/// Largest magnitude in v. NaN counts as infinite.
inline double largest_entry(const Eigen::Ref<const VectorXd>& v) {
  double worst = 0.0;
  for (const double x : v) raise(worst, x);
  return worst;
}

/// Raises both residuals for a hard row or variable with the given value and sides. The multiplier
/// must push against the active side: positive at the upper, negative at the lower one. Its product
/// with the distance to that side must vanish. Equal sides leave the multiplier free.
inline void add_hard(double value, double lower, double upper, double multiplier,
                     double& feasibility, double& complementarity) {
  if (!(value >= lower)) raise(feasibility, lower - value);
  if (!(value <= upper)) raise(feasibility, value - upper);
  if (lower == upper || multiplier == 0.0) return;
  const double distance = multiplier > 0.0 ? upper - value : value - lower;
  // A multiplier without a side in its direction counts in full.
  raise(complementarity,
        std::isfinite(distance) ? multiplier * std::max(distance, 0.0) : multiplier);
}

/// Slack of a soft side whose value misses it by `miss`. Rounding may leave a multiplier above the
/// slope l1 + l2 t of the penalty at t = max(miss, 0), which is an error of stationarity in t. At
/// the larger t that permits the multiplier it is an error multiplier (t - miss) of complementarity
/// instead. The smaller error decides.
inline double soft_slack(double miss, double l1, double l2, double multiplier) {
  const double least = std::max(miss, 0.0);
  return multiplier > l1 && multiplier < l2 ? std::max(least, (multiplier - l1) / l2) : least;
}

/// The same as add_hard() for a soft row. A side violated by t >= 0 costs l1 t + l2/2 t^2.
/// Optimality requires 0 <= multiplier <= l1 + l2 t: equal to the upper limit if t > 0, zero if the
/// side is inactive.
///
/// The value determines t, with one freedom. A multiplier that exceeds its limit by e is an error e
/// of stationarity in t. Since the limit rises with t, it is also an error multiplier x e / l2 of
/// complementarity at the t that permits it. The smaller error counts, as if t were a variable.
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
