// Hybrid systems with known answers, for the tests of events.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "framework/model/automaton.hpp"
#include "framework/model/integrator.hpp"
#include "integrators/cvodes.hpp"
#include "integrators/runge_kutta.hpp"

namespace saltus::test {

template <int nx, int nu, int np>
IntervalProblem hybrid_problem(const Automaton<nx, nu, np>& automaton,
                               InputShape shape = InputShape::constant) {
  IntervalProblem problem;
  problem.arguments = {nx, nu, np};
  problem.switching = automaton.system();
  problem.dynamics = problem.switching.modes.front().dynamics;
  problem.shape = shape;
  problem.differentiate_parameter.assign(np, true);
  problem.differentiate_time = true;
  return problem;
}

/// D07: x = (height m, speed m/s), p = (gravity m/s^2, restitution).
inline IntervalProblem bouncing_ball() {
  Automaton<2, 0, 2> ball;
  ball.mode("flight",
            [](const auto&, const auto& x, const auto&, const auto& p) {
              return std::decay_t<decltype(x)>{x[1], -p[0]};
            })
      .event(
          "impact", "flight", "flight", [](const auto&, const auto& x) { return x[0]; },
          Crossing::falling,
          [](const auto&, const auto& x, const auto&, const auto& p) {
            return std::decay_t<decltype(x)>{x[0], -p[1] * x[1]};
          });
  return hybrid_problem(ball);
}

/// D11: x = (y m, speed m/s), stance on a spring of rest length l0 between two flights; y is
/// measured from l0. Touchdown falling, lift-off rising.
struct SpringLeg {
  double mass = 80.0;      // kg
  double stiffness = 2e4;  // N/m
  double gravity = 9.81;   // m/s^2
  IntervalProblem problem() const {
    const double g = gravity, wn2 = stiffness / mass;
    Automaton<2> leg;
    leg.mode("flight",
             [g](const auto&, const auto& x) {
               return std::decay_t<decltype(x)>{x[1], -g + 0.0 * x[1]};
             })
        .mode("stance",
              [g, wn2](const auto&, const auto& x) {
                return std::decay_t<decltype(x)>{x[1], -g - wn2 * x[0]};
              })
        .surface("foot", "stance", "flight", [](const auto&, const auto& x) { return x[0]; });
    return hybrid_problem(leg);
  }
};

/// One state, `below` where x < 0 and `above` where x > 0.
template <class Below, class Above>
IntervalProblem scalar_filippov(Below below, Above above) {
  Automaton<1> system;
  system.mode("below", below)
      .mode("above", above)
      .surface("zero", "below", "above", [](const auto&, const auto& x) { return x[0]; });
  return hybrid_problem(system);
}

/// A field of one state that only depends on time: intercept + slope t.
struct Ramp {
  double intercept, slope;
  template <class S>
  S operator()(const S& t, const Vec<S, 1>&) const {
    return intercept + slope * t;
  }
};

/// A18: rotation whose sense changes at |x| = 1.
inline IntervalProblem oscillator() {
  constexpr double turn = 2.0 * std::numbers::pi;
  Automaton<2> system;
  system
      .mode("inside",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{x[0] - turn * x[1], turn * x[0] + x[1]};
            })
      .mode("outside",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{x[0] + turn * x[1], -turn * x[0] + x[1]};
            })
      .surface("circle", "inside", "outside",
               [](const auto&, const auto& x) { return x[0] * x[0] + x[1] * x[1] - 1.0; });
  return hybrid_problem(system);
}

inline const CvodesOptions tight_options{
    .method = CvodesMethod::Adams, .tolerance = 1e-12, .absolute_tolerance = 1e-14};

inline VectorXd vec(std::initializer_list<double> values) {
  return Eigen::Map<const VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace saltus::test
