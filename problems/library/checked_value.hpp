// A number with its reference value.
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace saltus {

struct CheckedValue {
  std::string name;        ///< "x(3)[0]", "dJ/dx0"
  double value = 0.0;      ///< computed value
  double reference = 0.0;  ///< published, computed independently, or in closed form
  double tolerance = 0.0;  ///< absolute
  int digits = 0;          ///< known digits of the reference; 0: unknown, or a residual

  double error() const { return std::abs(value - reference); }
  bool is_met() const { return error() <= tolerance; }  // false for NaN

  /// error / |reference|, or the error if the reference is zero.
  double relative_error() const {
    return reference == 0.0 ? error() : error() / std::abs(reference);
  }
  /// Error divided by the tolerance; infinite for NaN.
  double fraction_of_tolerance() const {
    if (is_met() && error() == 0.0) return 0.0;
    const double fraction = error() / tolerance;
    return std::isnan(fraction) ? std::numeric_limits<double>::infinity() : fraction;
  }
  /// Number of significant digits that agree with the reference. The error is at most half a unit
  /// of the last of them, plus half a unit of the last known digit, which may be rounded.
  int digits_reached() const {
    const double relative_unit = std::pow(10.0, leading_power()) / scale();
    int reached = 0;
    for (int k = 1; k <= digits; ++k)
      if (relative_error() <= 0.5 * relative_unit * (std::pow(10.0, 1 - k) + last_place()))
        reached = k;
    return reached;
  }

 private:
  double scale() const { return reference == 0.0 ? 1.0 : std::abs(reference); }
  double leading_power() const { return std::floor(std::log10(scale())); }
  double last_place() const { return std::pow(10.0, 1 - digits); }
};

/// A residual that should be zero, with its tolerance.
inline CheckedValue residual_of(std::string name, double value, double at_most) {
  return {.name = std::move(name), .value = value, .tolerance = at_most};
}

}  // namespace saltus
