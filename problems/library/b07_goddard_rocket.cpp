// Goddard's rocket flies as high as its fuel permits: full thrust, a singular arc, coast.
//
//   max h(tf)   h' = v, v' = (T - D) / m - 1 / h^2, m' = -2 T
//   D = 310 v^2 exp(-500 (h - 1)), 0 <= T <= 3.5, h(0) = 1, v(0) = 0, m(0) = 1, m(tf) = 0.6
//
// On the singular arc D (1 + v / c) = m / h^2 with c = 1/2. The solver does not know this: the
// thrust of the second phase is a free, continuous, piecewise linear function with few pieces,
// because the cost is insensitive to it. The thrust stays 10 % away from its bounds. At a bound
// this phase could replace its neighbours, and solvers could converge to neighbours of minimum
// length.
// Guess: at rest on the ground with all fuel, half thrust on the arc, 0.05 per phase.
// Source: COPS 3.0, rocket: 1.01283; data of Bryson, Dynamic Optimization. Further digits come from
// a simulation with the singular feedback.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double exhaust_speed = 0.5;
constexpr double full_thrust = 3.5;

struct Rocket {  // x = (height, speed, mass)
  template <class S>
  static S drag(const Vec<S, 3>& x) {
    return 310.0 * x[1] * x[1] * exp(-500.0 * (x[0] - 1.0));
  }
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 1>& T) const {
    return {x[1], (T[0] - drag(x)) / x[2] - 1.0 / (x[0] * x[0]), -T[0] / exhaust_speed};
  }
};

OptimalControlProblem problem() {
  const auto mass = [](const auto&, const auto& x) { return x[2]; };
  const auto minus_height = [](const auto&, const auto& x) { return -x[0]; };
  const Bounds part = between(0.005, 0.3);

  Phase<3, 1> boost{"boost", Rocket{}, part}, sustain{"sustain", Rocket{}, part};
  Phase<3, 1> coast{"coast", Rocket{}, part};
  boost.bound_input(0, exactly(full_thrust)).guess_input(Guess::constant(Vec<double, 1>{3.5}));
  sustain.bound_input(0, between(0.1 * full_thrust, 0.9 * full_thrust))
      .guess_input(Guess::constant(Vec<double, 1>{0.5 * full_thrust}))
      .inputs(InputParametrisation::piecewise_linear_continuous);
  coast.bound_input(0, exactly(0.0))
      .reach("empty", mass, exactly(0.6))
      .minimise_at_end("height", minus_height);

  OptimalControlProblem ocp("Goddard rocket");
  ocp.start_at({1, 0, 1});
  for (auto* phase : {&boost, &sustain, &coast}) {
    // Typical height above the ground and speed: 0.01 and 0.1.
    phase->nominal(Vec<double, 3>{0.01, 0.1, 1.0}, Vec<double, 1>{1.0})
        .nominal_duration(0.1)
        .guess_duration(0.05);
    ocp.then(*phase);
  }
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  const double t1 = s.durations[0];
  std::vector<CheckedValue> values{{"tf", s.trajectory.end_time(), 0.198856262105, 1e-4, 12},
                                   {"m(t1)", s.trajectory.state(t1)[2], 0.83543221, 1e-4, 8}};
  for (const double part : {0.25, 0.5, 0.75}) {  // positions on the arc that are compared
    const Vec<double, 3> x = s.trajectory.state(t1 + part * s.durations[1]);
    const double weight = x[2] / (x[0] * x[0]);
    values.push_back({"singular surface", Rocket::drag(x) * (1.0 + x[1] / exhaust_speed) / weight,
                      1.0, 1e-3, 16});
  }
  return values;
}

}  // namespace

ReferenceCase goddard_rocket() {
  return {.id = "B07",
          .name = "goddard_rocket",
          .summary = "Maximum altitude of Goddard's rocket: full thrust, singular arc, coast.",
          .states = {"height", "speed", "mass"},
          .inputs = {"thrust"},
          .exercises = "full thrust, singular arc, coast: three free durations",
          .source = "COPS 3.0, rocket; more digits by simulation with the singular feedback",
          .problem = problem,
          .options = {.intervals = {5, 6, 10}, .integrator = runge_kutta8({.steps = 2})},
          .optimum = -1.01283691832,
          .digits = 12,
          .tolerance = 1e-9,  // piecewise linear thrust on the arc
          .switching_times = {0.0235096840415, 0.0726707434415},
          .more = more};
}

}  // namespace saltus::library
