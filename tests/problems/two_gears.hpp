// The program of the design page: a car that changes gear once.
#pragma once

#include "saltus/ocp/problem.hpp"

namespace saltus::two_gears {

struct FirstGear {
  double thrust = 6.0;  // m/s^2 at full throttle
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], thrust * u[0] - 0.01 * x[1] * x[1]};
  }
};

struct SecondGear {
  double thrust = 3.0, braking = 8.0;  // m/s^2 at full throttle, at full brake
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u) const {
    return {x[1], thrust * u[0] - braking * u[1] - 0.01 * x[1] * x[1]};
  }
};

inline OptimalControlProblem problem() {
  const auto position = [](auto, auto x) { return x[0]; };
  const auto speed = [](auto, auto x) { return x[1]; };
  const auto clock = [](auto t, auto) { return t; };
  const auto effort = [](auto, auto, auto u) { return 0.01 * u.squaredNorm(); };

  Phase<2, 1> first{"first gear", FirstGear{}, between(0.5, 10.0)};  // free switch time, s
  first.bound_input(0, between(0.0, 1.0))
      .keep("rev limit", speed, at_most(12.0))
      .minimise("effort", effort);

  Phase<2, 2> second{"second gear", SecondGear{}, between(0.5, 20.0)};
  second.bound_input(0, between(0.0, 1.0))
      .bound_input(1, between(0.0, 1.0))
      .keep("clutch settles", speed, at_most(14.0), Window{.from = 0.0, .to = 0.3})
      .minimise("effort", effort)
      .reach("finish line", position, exactly(100.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock);

  OptimalControlProblem ocp("two gears");
  ocp.start_at({0, 0}).then(first).then(second, jump<2>("clutch", [](auto, auto x) {
                                          return decltype(x){x[0], x[1] * 0.97};
                                        }));
  return ocp;
}

}  // namespace saltus::two_gears
