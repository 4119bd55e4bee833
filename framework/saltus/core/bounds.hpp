// Lower and upper bounds of a quantity, and functions that construct them.
#pragma once

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

}  // namespace saltus
