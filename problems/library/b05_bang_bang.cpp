// A car brakes twice as hard as it accelerates and drives 300 m from rest to rest in minimum time.
//
//   min T   x'' = u, -2 <= u <= 1   x(0) = 0, x(T) = 300 m, at rest at both ends
//
// Closed form for the limits a forward and b backward over the distance D: T = sqrt(2 D (a + b) /
// (a b)), with the switch at T b / (a + b). The input is an unknown constant in each of two phases.
// Guess: the constant start, no input, ten seconds per phase.
// Source: ICLOCS2 examples, two-phase bang-bang; closed form.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Car {  // x = (position m, speed m/s), u = acceleration m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0]};
  }
};

OptimalControlProblem problem() {
  const auto position = [](const auto&, const auto& x) { return x[0]; };
  const auto speed = [](const auto&, const auto& x) { return x[1]; };
  const auto clock = [](const auto& t, const auto&) { return t; };

  Phase<2, 1> accelerate{"accelerate", Car{}, between(1.0, 100.0)};
  Phase<2, 1> brake{"brake", Car{}, between(1.0, 100.0)};
  for (auto* phase : {&accelerate, &brake})
    phase->bound_input(0, between(-2.0, 1.0))
        .nominal(Vec<double, 2>{100.0, 10.0}, Vec<double, 1>{1.0})
        .nominal_duration(10.0)
        .guess_duration(10.0);
  brake.reach("distance", position, exactly(300.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock);

  OptimalControlProblem ocp("bang-bang");
  ocp.start_at({0, 0}).then(accelerate).then(brake);
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  return {{"u before the switch", s.trajectory.input(10.0)[0], 1.0, 1e-7, 16},
          {"u after the switch", s.trajectory.input(25.0)[0], -2.0, 1e-7, 16},
          {"top speed", s.trajectory.state(s.durations[0])[1], 20.0, 1e-6, 16}};
}

}  // namespace

ReferenceCase bang_bang() {
  return {
      .id = "B05",
      .name = "bang_bang",
      .summary = "A car that brakes twice as hard as it accelerates drives 300 m in minimum time.",
      .states = {"position [m]", "speed [m/s]"},
      .inputs = {"acceleration [m/s^2]"},
      .exercises = "minimum time, two free durations, unknown constant inputs",
      .source = "ICLOCS2 examples; closed form",
      .problem = problem,
      // Positions are quadratic: one interval per phase is exact.
      .options = {.intervals_per_phase = 1, .integrator = runge_kutta4()},
      .optimum = 30.0,
      .digits = 16,
      .tolerance = 1e-9,  // tolerance of the solver
      .switching_times = {20.0},
      .switching_tolerance = 1e-7,  // the constraints determine both durations
      .more = more};
}

}  // namespace saltus::library
