// Lower and upper bounds of a quantity, written the way one says them.
#pragma once

#include <limits>

namespace saltus {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// A closed interval; an absent side is infinite. Equal sides make an equality.
struct Bounds {
  double lower = -infinity;
  double upper = infinity;

  bool is_equality() const { return lower == upper; }
  bool is_free() const { return lower == -infinity && upper == infinity; }
  bool is_empty() const { return !(lower <= upper); }  // also true for NaN
  friend bool operator==(const Bounds&, const Bounds&) = default;
};

inline Bounds exactly(double value) { return {value, value}; }
inline Bounds between(double lower, double upper) { return {lower, upper}; }
inline Bounds at_least(double lower) { return {lower, infinity}; }
inline Bounds at_most(double upper) { return {-infinity, upper}; }
inline Bounds unbounded() { return {}; }

}  // namespace saltus
