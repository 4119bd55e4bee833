// Range of numbers that a setting accepts; its ends may be excluded.
#pragma once

#include <string>

#include "saltus/core/bounds.hpp"

namespace saltus {

/// An interval of allowed numbers. Ranges from `Bounds` (`at_least(0)`, `between(0, 1)`) include
/// their ends; those from `above`, `below` or `strictly_between` do not.
struct Range {
  double lower = -infinity;     ///< smallest allowed number
  double upper = infinity;      ///< largest allowed number
  bool lower_excluded = false;  ///< `lower` itself is not allowed
  bool upper_excluded = false;  ///< `upper` itself is not allowed

  Range() = default;
  /// Range with both ends included.
  Range(const Bounds& bounds) : lower(bounds.lower), upper(bounds.upper) {}  // NOLINT: intended

  /// False for NaN.
  bool contains(double value) const {
    const bool low_enough = upper_excluded ? value < upper : value <= upper;
    const bool high_enough = lower_excluded ? value > lower : value >= lower;
    return low_enough && high_enough;
  }
  /// True if every number is allowed.
  bool is_free() const { return lower == -infinity && upper == infinity; }

  /// Text for messages: "at least 0 N s", "above 0 and at most 1"; empty if every number is
  /// allowed.
  std::string text(const std::string& unit = "") const;
};

/// Numbers greater than `lower`.
inline Range above(double lower) {
  Range range{at_least(lower)};
  range.lower_excluded = true;
  return range;
}

/// Numbers less than `upper`.
inline Range below(double upper) {
  Range range{at_most(upper)};
  range.upper_excluded = true;
  return range;
}

/// Numbers greater than `lower` and less than `upper`.
inline Range strictly_between(double lower, double upper) {
  Range range{between(lower, upper)};
  range.lower_excluded = range.upper_excluded = true;
  return range;
}

}  // namespace saltus
