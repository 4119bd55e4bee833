// Common parts of the fishing problems with a given sequence (a06_fishing.cpp) and without one
// (s04_fishing_modes.cpp).
#pragma once

#include "saltus/ocp/phase.hpp"

namespace saltus::library {

struct Populations {  // x = (prey, predators)
  double fishing;     // w

  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x) const {
    const S meeting = x[0] * x[1];
    return {x[0] - meeting - 0.4 * fishing * x[0], -x[1] + meeting - 0.2 * fishing * x[1]};
  }
};

/// (x1 - 1)^2 + (x2 - 1)^2: distance of both populations from 1.
struct Deviation {
  template <class S>
  S operator()(const S&, const Vec<S, 2>& x) const {
    const S a = x[0] - 1.0, b = x[1] - 1.0;
    return a * a + b * b;
  }
};

}  // namespace saltus::library
