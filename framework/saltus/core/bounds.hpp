// Lower and upper bounds of a quantity, and functions that construct them.
#pragma once

#include <initializer_list>
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
/// Default tolerance for a violation of the bounds: 1e-6 times the largest of 1 and the magnitudes
/// of the finite sides.
inline double bound_tolerance(const Bounds& b) {
  double size = 1.0;
  for (const double side : {b.lower, b.upper}) {
    const double magnitude = side < 0.0 ? -side : side;
    if (magnitude < infinity && magnitude > size) size = magnitude;
  }
  return 1e-6 * size;
}

}  // namespace saltus
