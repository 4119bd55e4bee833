// Lower and upper bounds of a quantity, and functions that construct them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace saltus {

inline constexpr double infinity = std::numeric_limits<double>::infinity();  ///< no bound

/// A closed interval. A missing side is infinite. Equal sides make an equality constraint.
struct Bounds {
  double lower = -infinity;  ///< -infinity if there is no lower bound
  double upper = infinity;   ///< infinity if there is no upper bound

  /// True if the bounds allow exactly one value.
  bool is_equality() const { return lower == upper; }
  /// True if the bounds allow every value.
  bool is_free() const { return lower == -infinity && upper == infinity; }
  /// True if the bounds allow no finite value. Also true if a side is NaN.
  bool is_empty() const { return !(lower <= upper) || lower == infinity || upper == -infinity; }
  friend bool operator==(const Bounds&, const Bounds&) = default;
};

/// Bounds that allow only this value.
inline Bounds exactly(double value) { return {value, value}; }
/// Bounds from lower to upper, both included.
inline Bounds between(double lower, double upper) { return {lower, upper}; }
/// Lower bound only.
inline Bounds at_least(double lower) { return {lower, infinity}; }
/// Upper bound only.
inline Bounds at_most(double upper) { return {-infinity, upper}; }
/// No bounds.
inline Bounds unbounded() { return {}; }

// Rules for bounds: which magnitudes count as unbounded, and which violations are tolerated.

/// Bounds of this magnitude or more count as infinite. Other tools write such values for
/// "unbounded".
inline constexpr double no_bound = 1e19;
/// Replaces sides beyond no_bound by infinity.
inline Bounds without_sentinels(const Bounds& b) {
  return {b.lower <= -no_bound && b.upper > -no_bound ? -infinity : b.lower,
          b.upper >= no_bound && b.lower < no_bound ? infinity : b.upper};
}
/// Default tolerance for a violation of one bound: 1e-6 times the larger of 1 and its magnitude.
inline double bound_tolerance(double bound) {
  const double magnitude = std::abs(bound);
  return 1e-6 * (magnitude > 1.0 && magnitude < infinity ? magnitude : 1.0);
}
/// Deprecated: the larger tolerance of the two bounds.
[[deprecated("use violation_in_tolerances; removed in 0.4")]] inline double bound_tolerance(
    const Bounds& b) {
  return std::max(bound_tolerance(b.lower), bound_tolerance(b.upper));
}
/// Violation of the bounds by a value, relative to the tolerance of the violated bound. Values
/// above 1 are not tolerated. A huge bound on one side does not hide a violation of the other one.
inline double violation_in_tolerances(const Bounds& b, double value) {
  double worst = -infinity;  // the order of the arguments of max() keeps NaN
  if (b.lower > -infinity) worst = std::max((b.lower - value) / bound_tolerance(b.lower), worst);
  if (b.upper < infinity) worst = std::max((value - b.upper) / bound_tolerance(b.upper), worst);
  return worst;
}

}  // namespace saltus
