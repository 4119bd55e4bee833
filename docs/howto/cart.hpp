// The example of the how-to page: a cart moves over a given distance against air drag.
#pragma once

#include <cstdio>
#include <saltus/saltus.hpp>

using namespace saltus;

struct Cart {  // x = (position m, speed m/s), u = force per mass, m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 0.2 * x[1] * sqrt(x[1] * x[1] + 0.01)};
  }
};

inline constexpr auto position = [](auto, auto x) { return x[0]; };
inline constexpr auto speed = [](auto, auto x) { return x[1]; };
inline constexpr auto pull = [](auto, auto, auto u) { return u[0]; };

// From rest to rest over `distance` (m) in 2 s with minimum effort.
inline OptimalControlProblem ride(double distance = 1.0) {
  Phase<2, 1> phase{"ride", Cart{}, exactly(2.0)};
  phase.bound_input(0, between(-3.0, 3.0))
      .track("effort", pull, VectorXd::Ones(1))
      .reach("there", position, exactly(distance))
      .reach("at rest", speed, exactly(0.0));
  OptimalControlProblem problem("ride");
  problem.start_at({0.0, 0.0}).then(phase);
  return problem;
}
