// Hybrid systems with known answers, for the simulations of the library and the tests of the
// integrators.
#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "saltus/integrators/simulate.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/model/automaton.hpp"
#include "saltus/model/integrator.hpp"

// A separate namespace, because a case of the catalogue may have the name of a system.
namespace saltus::library {
inline namespace hybrid_systems {

/// An automaton as the problem of one interval, differentiated with respect to everything.
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

/// p = (gravity m/s^2, restitution).
struct FreeFall {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 0>&, const Vec<S, 2>& p) const {
    return {x[1], -p[0]};
  }
};
struct Bounce {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 0>&, const Vec<S, 2>& p) const {
    return {x[0], -p[1] * x[1]};
  }
};

/// A bouncing ball: x = (height m, speed m/s),
/// p = (gravity m/s^2, restitution).
inline IntervalProblem bouncing_ball() {
  const auto height = [](const auto&, const auto& x) { return x[0]; };
  Automaton<2, 0, 2> ball;
  ball.mode("flight", FreeFall{})
      .event("impact", "flight", "flight", height, Crossing::falling, Bounce{});
  return hybrid_problem(ball);
}

/// y'' = -gravity - stiffness y
struct Leg {
  double gravity, stiffness;  // m/s^2, 1/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x) const {
    return {x[1], -gravity - stiffness * x[0]};
  }
};

/// A mass that lands on a massless spring leg and takes off again, vertically:
/// x = (height over the rest length of the leg m, speed m/s).
struct SpringLeg {
  double mass = 80.0;      // kg
  double stiffness = 2e4;  // N/m
  double gravity = 9.81;   // m/s^2

  double frequency() const { return std::sqrt(stiffness / mass); }  // rad/s
  IntervalProblem problem() const {
    const auto height = [](const auto&, const auto& x) { return x[0]; };
    Automaton<2> leg;
    leg.mode("stance", Leg{gravity, stiffness / mass})
        .mode("flight", Leg{gravity, 0.0})
        .surface("foot", "stance", "flight", height);
    return hybrid_problem(leg);
  }
};

/// Growth of rate 1/s with rotation.
struct Spiral {
  double turn;  // rad/s
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x) const {
    return {x[0] - turn * x[1], turn * x[0] + x[1]};
  }
};

/// Oscillator that changes its sense of rotation at |x| = 1.
inline IntervalProblem oscillator() {
  const auto radius = [](const auto&, const auto& x) { return x[0] * x[0] + x[1] * x[1] - 1.0; };
  Automaton<2> system;
  system.mode("inside", Spiral{2.0 * std::numbers::pi})
      .mode("outside", Spiral{-2.0 * std::numbers::pi})
      .surface("circle", "inside", "outside", radius);
  return hybrid_problem(system);
}

/// Speed that depends only on time, m/s and m/s^2.
struct Ramp {
  double intercept, slope;
  template <class S>
  S operator()(const S& t, const Vec<S, 1>&) const {
    return intercept + slope * t;
  }
};

/// x' = below(t) where x < 0 and above(t) where x > 0.
inline IntervalProblem scalar_filippov(Ramp below, Ramp above) {
  Automaton<1> system;
  system.mode("below", below)
      .mode("above", above)
      .surface("zero", "below", "above", [](const auto&, const auto& x) { return x[0]; });
  return hybrid_problem(system);
}

/// Local error 1e-12, as required by answers with twelve digits.
inline IntegratorChoice tight_scheme() {
  return cvodes(
      {.method = CvodesOptions::Method::Adams, .tolerance = 1e-12, .absolute_tolerance = 1e-14});
}
inline HybridSimulation simulate_tightly(const IntervalProblem& problem, const VectorXd& x0,
                                         const VectorXd& times, const VectorXd& p = VectorXd()) {
  return simulate_hybrid(tight_scheme(), problem, x0, times, MatrixXd(0, times.size() - 1), p);
}

/// Time of an event; NaN if it does not exist.
inline double event_time(const HybridSimulation& simulation, std::size_t index) {
  return index < simulation.events.size() ? simulation.events[index].time : std::nan("");
}

inline VectorXd numbers(std::initializer_list<double> values) {
  return Eigen::Map<const VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace hybrid_systems
}  // namespace saltus::library
