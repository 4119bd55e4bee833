// Rules for bounds: which magnitudes count as unbounded, and which violations are tolerated.
#pragma once

#include <initializer_list>

#include "saltus/core/bounds.hpp"

namespace saltus {

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
inline double tolerance_of(const Bounds& b) {
  double size = 1.0;
  for (const double side : {b.lower, b.upper}) {
    const double magnitude = side < 0.0 ? -side : side;
    if (magnitude < infinity && magnitude > size) size = magnitude;
  }
  return 1e-6 * size;
}

}  // namespace saltus
