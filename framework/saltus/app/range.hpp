// Which numbers a setting accepts: an interval whose ends may be excluded.
#pragma once

#include <string>

#include "saltus/core/bounds.hpp"

namespace saltus {

/// An interval of allowed numbers. Made from `Bounds` (`at_least(0)`, `between(0, 1)`) its ends
/// belong to it; made by `above`, `below` or `strictly_between` they do not.
struct Range {
  double lower = -infinity;     ///< no number below it is allowed
  double upper = infinity;      ///< no number above it is allowed
  bool lower_excluded = false;  ///< `lower` itself is not allowed
  bool upper_excluded = false;  ///< `upper` itself is not allowed

  Range() = default;
  /// Both ends allowed.
  Range(const Bounds& bounds) : lower(bounds.lower), upper(bounds.upper) {}  // NOLINT: intended

  /// False for NaN.
  bool contains(double value) const {
    const bool low_enough = upper_excluded ? value < upper : value <= upper;
    const bool high_enough = lower_excluded ? value > lower : value >= lower;
    return low_enough && high_enough;
  }
  /// Whether every number is allowed.
  bool is_free() const { return lower == -infinity && upper == infinity; }

  /// "at least 0 N s", "above 0 and at most 1"; empty if every number is allowed.
  std::string text(const std::string& unit = "") const;
};

/// More than `lower`.
inline Range above(double lower) {
  Range range{at_least(lower)};
  range.lower_excluded = true;
  return range;
}

/// Less than `upper`.
inline Range below(double upper) {
  Range range{at_most(upper)};
  range.upper_excluded = true;
  return range;
}

/// More than `lower` and less than `upper`.
inline Range strictly_between(double lower, double upper) {
  Range range{between(lower, upper)};
  range.lower_excluded = range.upper_excluded = true;
  return range;
}

}  // namespace saltus
