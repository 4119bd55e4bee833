// Two tanks, one above the other. The lower tank follows a decreasing level, 3 - 0.05 t.
//
//   min int_0^10 (x2 - (3 - 0.05 t))^2   x1' = 1 + w - sqrt(x1), x2' = sqrt(x1) - sqrt(x2)
//   x(0) = (2, 2)
//
// The relaxed problem has 0 <= w <= 1: full inflow until t = 4.1763, then values between the
// bounds. The sequence has 16 phases with w = 0, 1, 0, 1, ... and free durations, which may be
// zero. The relaxed optimum is a lower bound, and a solver finds one of many local optima. For the
// sequence the test requires feasibility, a small KKT residual and a cost within 5 % of the bound.
// Guesses: w = 0.5; for the sequence, phases of equal length and simulated levels.
// Source: double tank of ampl_mintoc; SwitchTimeOpt.jl, examples/tank.jl. The relaxed optimum was
// computed independently.
#include <fmt/format.h>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double horizon = 10.0;
constexpr int modes = 16;

struct Tanks {  // x = (upper level, lower level), w = inflow
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& w) const {
    const S out_of_upper = sqrt(x[0]), out_of_lower = sqrt(x[1]);
    return {1.0 + w[0] - out_of_upper, out_of_upper - out_of_lower};
  }
};

struct TanksInMode {
  double inflow;

  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x) const {
    const S out_of_upper = sqrt(x[0]), out_of_lower = sqrt(x[1]);
    return {1.0 + inflow - out_of_upper, out_of_upper - out_of_lower};
  }
};

constexpr auto miss = [](const auto& t, const auto& x) {
  const auto off = x[1] - (3.0 - 0.05 * t);
  return off * off;
};

OptimalControlProblem relaxed() {
  Phase<2, 1> phase{"relaxed", Tanks{}, exactly(horizon)};
  phase.minimise("miss", [](const auto& t, const auto& x, const auto&) { return miss(t, x); })
      .bound_input(0, between(0.0, 1.0))
      .guess_input(Guess::constant(Vec<double, 1>{0.5}));
  OptimalControlProblem ocp("tank on a ramp, relaxed");
  ocp.start_at({2, 2}).then(phase);
  return ocp;
}

OptimalControlProblem sequence() {
  OptimalControlProblem ocp("tank on a ramp, 16 modes");
  ocp.start_at({2, 2});
  for (int i = 0; i < modes; ++i) {
    const bool fills = i % 2 == 1;
    Phase<2, 0> phase{fmt::format("{} {}", fills ? "fill" : "drain", i / 2 + 1),
                      TanksInMode{fills ? 1.0 : 0.0}, between(0.0, horizon)};
    phase.minimise("miss", miss).guess_state(Guess::simulate()).guess_duration(horizon / modes);
    ocp.then(phase);
  }
  ocp.total_time(exactly(horizon));
  return ocp;
}

constexpr double relaxed_optimum = 1.858061;

}  // namespace

ReferenceCase tank_on_ramp() {
  return {.id = "A12a",
          .name = "tank_on_ramp",
          .summary = "Two tanks in series: the lower one tracks a falling level.",
          .states = {"upper level", "lower level"},
          .inputs = {"inflow"},
          .exercises = "a bang-bang and a singular arc on 400 intervals",
          .source = "ampl_mintoc, doubleTank; computed independently to seven digits",
          .problem = relaxed,
          .options = {.intervals_per_phase = 400, .integrator = runge_kutta4()},
          .optimum = relaxed_optimum,
          .digits = 7,
          .tolerance = 1e-6};  // accuracy of the reference
}

ReferenceCase tank_sequence() {
  return {.id = "A12b",
          .name = "tank_sequence",
          .summary = "The same problem with 16 switches of the inflow.",
          .states = {"upper level", "lower level"},
          .exercises = "sixteen phases without inputs, which may vanish, and many local optima",
          .source = "SwitchTimeOpt.jl, examples/tank.jl; the relaxed optimum is a lower bound",
          .problem = sequence,
          .options = {.intervals_per_phase = 4, .integrator = runge_kutta8({.steps = 2})},
          .optimum = relaxed_optimum,
          .digits = 2,
          .tolerance = 1e-4};  // the sequence costs a little more than the relaxed optimum
}

}  // namespace saltus::library
