// Lower and upper bounds of a quantity, written the way one says them.
#pragma once

#include <limits>

namespace saltus {

inline constexpr double infinity = std::numeric_limits<double>::infinity();  ///< no bound

/// A closed interval; an absent side is infinite. Equal sides make an equality.
struct Bounds {
  double lower = -infinity;  ///< none if it is -infinity
  double upper = infinity;   ///< none if it is infinity

  /// Whether one value alone is allowed.
  bool is_equality() const { return lower == upper; }
  /// Whether every value is allowed.
  bool is_free() const { return lower == -infinity && upper == infinity; }
  /// Whether no finite value is allowed; also true for NaN.
  bool is_empty() const { return !(lower <= upper) || lower == infinity || upper == -infinity; }
  friend bool operator==(const Bounds&, const Bounds&) = default;
};

/// This value alone.
inline Bounds exactly(double value) { return {value, value}; }
/// From lower to upper, both included.
inline Bounds between(double lower, double upper) { return {lower, upper}; }
/// From lower on.
inline Bounds at_least(double lower) { return {lower, infinity}; }
/// Up to upper.
inline Bounds at_most(double upper) { return {-infinity, upper}; }
/// Whatever it is.
inline Bounds unbounded() { return {}; }

}  // namespace saltus
