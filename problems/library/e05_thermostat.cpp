// A thermostat with hysteresis: between its two temperatures the state does not determine the mode.
// The unknown is the power of the heater that brings the room to 1.5 at the end.
//
//   min p^2   heating: x' = p - x until x = 2,   idle: x' = -x until x = 1
//   x(0) = 1, heating; x(T) = 3/2 with T = ln(16 / 3)
//
// It heats for ln((p - 1) / (p - 2)), idles for ln 2, and heats again: 2 e^-T (p - 1)^2 = (p - 3/2)
// (p - 2), whose root above 2 is p = 3. So p^2 = 9, and the events are at ln 2 and ln 4.
// Guess: p = 2.8, simulated.
// Source: closed form.
#include <cmath>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/model/automaton.hpp"

namespace saltus::library {
namespace {

Automaton<2, 0, 1> thermostat() {  // x = (temperature, mode)
  const auto heating = [](const auto&, const auto& x, const auto&, const auto& p) {
    auto rate = x.eval();
    rate[0] = p[0] - x[0];
    rate[1] = 0.0;
    return rate;
  };
  const auto idle = [](const auto&, const auto& x) {
    auto rate = x.eval();
    rate[0] = -x[0];
    rate[1] = 0.0;
    return rate;
  };
  Automaton<2, 0, 1> heater;
  heater.mode("heating", heating)
      .mode("idle", idle)
      .store_mode_in(1)
      .event(
          "warm", "heating", "idle", [](const auto&, const auto& x) { return x[0] - 2.0; },
          Crossing::rising)
      .event(
          "cold", "idle", "heating", [](const auto&, const auto& x) { return x[0] - 1.0; },
          Crossing::falling);
  return heater;
}

OptimalControlProblem problem() {
  Phase<2, 0, 1> room{"room", thermostat(), exactly(std::log(16.0 / 3.0))};
  room.unknown("heater", Vec<double, 1>{2.8}, between(2.2, 5.0))
      .minimise_at_end(
          "size", [](const auto&, const auto&, const auto&, const auto& p) { return p[0] * p[0]; })
      .reach(
          "temperature", [](const auto&, const auto& x) { return x[0]; }, exactly(1.5))
      .guess_state(Guess::simulate());
  OptimalControlProblem ocp("thermostat");
  return ocp.start_at({1, 0}).then(room);
}

}  // namespace

ReferenceCase thermostat_size() {
  return {.id = "E05",
          .name = "thermostat",
          .summary = "A heater with hysteresis is sized for a temperature at the end.",
          .states = {"temperature", "mode"},
          .inputs = {},
          .exercises = "hysteresis: the mode is stored from interval to interval",
          .source = "closed form",
          .problem = problem,
          .options = {.intervals_per_phase = 12, .integrator = runge_kutta8({.steps = 2})},
          .optimum = 9.0,
          .digits = 15,
          .tolerance = 1e-8};  // tolerance of the solver; one equation determines the optimum
}

}  // namespace saltus::library
