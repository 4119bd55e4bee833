// When is a side of some bounds none, and when is a violation of them none?
#pragma once

#include <initializer_list>

#include "saltus/core/bounds.hpp"

namespace saltus {

/// Sides from this magnitude on are no sides: what other tools write for "unbounded".
inline constexpr double no_bound = 1e19;
/// The bounds with sides beyond no_bound left out.
inline Bounds without_sentinels(const Bounds& b) {
  return {b.lower <= -no_bound && b.upper > -no_bound ? -infinity : b.lower,
          b.upper >= no_bound && b.lower < no_bound ? infinity : b.upper};
}
/// Violation of bounds that counts as none where nobody says more: 1e-6 times the largest of 1 and
/// the finite sides.
inline double tolerance_of(const Bounds& b) {
  double size = 1.0;
  for (const double side : {b.lower, b.upper}) {
    const double magnitude = side < 0.0 ? -side : side;
    if (magnitude < infinity && magnitude > size) size = magnitude;
  }
  return 1e-6 * size;
}

}  // namespace saltus
