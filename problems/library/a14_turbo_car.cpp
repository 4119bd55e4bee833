// A car with a turbo charger that works above 10 m/s drives 200 m from rest to rest in minimum
// time.
//
//   min T   q' = v, v' = u where v < 10, 3 u where v > 10   |u| <= 5, |v| <= 20
//   (q, v)(0) = (0, 0), (q, v)(T) = (200, 0)
//
// The state switches the mode at v = 10 m/s, accelerating and braking. The optimum is full throttle
// (2 s), turbo (2/3 s), cruise at the speed limit (8 s), and the mirror image: T = 40/3. One
// interval with a constant input is enough for each phase except the cruise, where the input is
// free. It cannot gain time there: with constant inputs the speed is linear between the nodes, so a
// limit at the nodes holds between them. Bounds at collocation points of higher order do not hold
// between these points and give 13.2366.
// Guess: at each phase change the speed of the switch and another fifth of the way, linear between
// them, no input, three seconds per phase.
// Source: nosnoc, examples/pss_tutorial_example; nosbench, CARTIM.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double turbo_speed = 10.0, top_speed = 20.0;  // m/s

struct Car {
  double gain;  // m/s^2 per unit of throttle
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], gain * u[0]};
  }
};

OptimalControlProblem problem() {
  const auto clock = [](const auto& t, const auto&) { return t; };
  const auto position = [](const auto&, const auto& x) { return x[0]; };
  const auto speed = [](const auto&, const auto& x) { return x[1]; };
  const auto above_turbo = [](const auto&, const auto& x) { return x[1] - turbo_speed; };
  const Bounds part = between(0.1, 20.0);  // s
  const Car nominal{1.0}, turbo{3.0};

  Phase<2, 1> start{"start", nominal, part};
  start.ends_when("turbo on", above_turbo, Crossing::rising);
  Phase<2, 1> charge{"charge", turbo, part};
  charge.bound_state(1, at_most(top_speed));
  Phase<2, 1> cruise{"cruise", turbo, part};
  cruise.bound_state(1, between(turbo_speed, top_speed));
  Phase<2, 1> brake{"brake", turbo, part};
  brake.bound_state(1, at_most(top_speed)).ends_when("turbo off", above_turbo, Crossing::falling);
  Phase<2, 1> stop{"stop", nominal, part};
  stop.reach("at the end", position, exactly(200.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock);

  const double speeds[] = {0.0, turbo_speed, top_speed, top_speed, turbo_speed, 0.0};
  OptimalControlProblem ocp("turbo car");
  ocp.start_at({0, 0});
  int j = 0;
  for (auto* phase : {&start, &charge, &cruise, &brake, &stop}) {
    phase->bound_input(0, between(-5.0, 5.0))
        .nominal(Vec<double, 2>{100, 10}, Vec<double, 1>{5})
        .guess_state(Guess::interpolate(Vec<double, 2>{40.0 * j, speeds[j]},
                                        Vec<double, 2>{40.0 * (j + 1), speeds[j + 1]}))
        .guess_duration(3.0);
    ocp.then(*phase);
    ++j;
  }
  return ocp;
}

}  // namespace

ReferenceCase turbo_car() {
  return {.id = "A14",
          .name = "turbo_car",
          .summary = "A car with a turbo charger that works above 10 m/s, 200 m from rest to rest.",
          .states = {"position [m]", "speed [m/s]"},
          .inputs = {"throttle [m/s^2]"},
          .exercises = "modes switched by the state, speed limits that hold between the nodes",
          .source = "nosnoc, pss_tutorial_example; closed form",
          .problem = problem,
          // Positions are quadratic: one step of order four per interval is exact.
          .options = {.intervals = {1, 1, 8, 1, 1}, .integrator = runge_kutta4()},
          .optimum = 40.0 / 3.0,
          .digits = 16,
          .tolerance = 1e-9,  // tolerance of the solver; transcription and integration are exact
          .switching_times = {2.0, 8.0 / 3.0, 32.0 / 3.0, 34.0 / 3.0}};
}

}  // namespace saltus::library
