// Disturbances of limited duration: pushes and gusts.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus {

/// Shape of a pulse over time. It does not change the impulse.
enum class PulseShape { rectangle, half_sine, triangle };
/// Name in tables and settings.
const char* describe(PulseShape shape);

/// An impulse that is spread over a limited time, such as a push or a gust.
struct Pulse {
  /// Size of the impulse, in N s for a force; it multiplies `direction`.
  double impulse = 0.0;
  VectorXd direction;     ///< unit vector of a force, or change of the state (nx)
  double start = 0.0;     ///< s
  double duration = 0.1;  ///< s
  PulseShape shape = PulseShape::rectangle;  ///< shape over time

  double end() const { return start + duration; }  ///< s
  /// Fraction of the impulse applied up to `t` seconds, 0 to 1.
  double fraction(double t) const;
  /// Mean force over an interval in seconds. Applied as a constant it gives exactly the impulse of
  /// the interval, wherever the interval begins and ends.
  VectorXd mean(double from, double to) const;
};

}  // namespace saltus
