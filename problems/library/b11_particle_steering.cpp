// A particle with constant thrust reaches a height of 5 and a horizontal velocity of 45 in minimum
// time. The input is the direction of the thrust.
//
//   min T   x'' = 100 cos u, y'' = 100 sin u, |u| <= pi/2
//   start: at rest in the origin; end: y = 5, x' = 45, y' = 0
//
// x is free and appears nowhere, so the state is (y, x', y'). Linear tangent law: tan u decreases
// linearly in time from tan u0 to -tan u0, which gives T and u0 in closed form.
// Guess: y from 0 to 5, the velocity from rest to (45, 0), no input, one second.
// Source: COPS 3.1, "particle steering", whose coarse grid gives 0.554577; Bryson and Ho, sec. 2.7.
#include <numbers>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double thrust = 100.0;  // acceleration

struct Particle {  // x = (y, x', y')
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 1>& u) const {
    return {x[2], thrust * cos(u[0]), thrust * sin(u[0])};
  }
};

OptimalControlProblem problem() {
  const auto clock = [](const auto& t, const auto&) { return t; };
  const auto state = [](const auto&, const auto& x) { return x; };
  const Vec<double, 3> start{0, 0, 0}, end{5, 45, 0};

  Phase<3, 1> steer{"steer", Particle{}, between(0.1, 10.0)};
  steer.inputs(InputParametrisation::piecewise_linear_continuous)
      .bound_input(0, between(-std::numbers::pi / 2, std::numbers::pi / 2))
      .minimise_at_end("time", clock)
      .reach("end", state, {exactly(end[0]), exactly(end[1]), exactly(end[2])})
      .nominal(Vec<double, 3>{5, 50, 50}, Vec<double, 1>{1})
      .guess_state(Guess::interpolate(start, end))
      .guess_duration(1.0);
  OptimalControlProblem ocp("particle steering");
  ocp.start_at(start).then(steer);
  return ocp;
}

std::vector<CheckedValue> more(const Solution& solution) {
  const Trajectory& trajectory = solution.trajectory;
  const double u0 = 0.953409756440;
  // Piecewise linear u with h = T/40 has an error of up to h^2 |u''| / 8 = 4e-4.
  constexpr double of_input = 4e-4;
  return {{"u(0)", trajectory.input(0.0)[0], u0, of_input, 12},
          {"u(T/2)", trajectory.input(trajectory.end_time() / 2.0)[0], 0.0, of_input, 16},
          {"u(T)", trajectory.input(trajectory.end_time())[0], -u0, of_input, 12}};
}

}  // namespace

ReferenceCase particle_steering() {
  return {.id = "B11",
          .name = "particle_steering",
          .summary = "Minimum-time steering of a particle by the direction of a constant thrust.",
          .states = {"height", "horizontal speed", "vertical speed"},
          .inputs = {"direction [rad]"},
          .exercises = "one phase of free duration, minimum time, a smooth input within bounds",
          .source = "COPS 3.1, particle steering; closed form",
          .problem = problem,
          .options = {.intervals_per_phase = 40, .integrator = runge_kutta8()},
          .optimum = 0.554570878334603,
          .digits = 15,
          .tolerance = 1e-7,  // piecewise linear inputs cost an excess of order h^4
          .more = more};
}

}  // namespace saltus::library
