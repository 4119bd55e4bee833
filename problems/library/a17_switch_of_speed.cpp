// A point moves three times as fast below zero as above it. Only its start is free.
//
//   min int_0^2 x^2 dt + (x(2) - 5/3)^2   x' = 3 where x < 0, 1 where x > 0,   -6 <= x(0) <= 0
//
// For a start in (-6, 0) the state crosses zero at -x(0) / 3, and dx(2)/dx(0) = 1/3, because the
// switching time depends on the start. If the crossing is ignored, the derivative is 1 for every
// step size, and false local minima appear. With it, J is a cubic in x(0) with one minimum.
// Guess: the simulation from x(0) = -3.
// Source: Nurkanovic, Sperl, Albrecht and Diehl, Finite elements with switch detection for direct
// optimal control of nonsmooth systems, 2024; nosnoc, examples/ivp_problem; closed form.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Speed {
  double value;  // m/s
  template <class S>
  S operator()(const S&, const Vec<S, 1>&) const {
    return S(value);
  }
};

OptimalControlProblem problem() {
  const auto position = [](const auto&, const auto& x) { return x[0]; };
  const auto square = [](const auto&, const auto& x) { return x[0] * x[0]; };
  const auto miss = [](const auto&, const auto& x) {
    return (x[0] - 5.0 / 3.0) * (x[0] - 5.0 / 3.0);
  };
  Phase<1, 0> drive("drive", Speed{3.0}, exactly(2.0));
  drive.switch_at("zero", position, Speed{1.0})
      .minimise("square", square)
      .minimise_at_end("miss", miss)
      .guess_state(Guess::simulate());
  OptimalControlProblem ocp("switch of speed");
  ocp.start_within({between(-6.0, 0.0)}, VectorXd::Constant(1, -3.0)).then(drive);
  return ocp;
}

}  // namespace

ReferenceCase switch_of_speed() {
  return {.id = "A17",
          .name = "switch_of_speed",
          .summary = "Optimal start of a point that moves three times as fast below zero as above.",
          .states = {"x"},
          .exercises = "a state-triggered switch inside an interval, differentiated through",
          .source = "Nurkanovic and others 2024, nosnoc examples/ivp_problem; closed form",
          .problem = problem,
          // States are linear, costs quadratic: the scheme is exact on both sides of the switch.
          .options = {.intervals_per_phase = 4, .integrator = runge_kutta4()},
          .optimum = 1.523772775374957,
          .digits = 16,
          .tolerance = 1e-8,  // tolerance of the solver; transcription and integration are exact
          .more = [](const Solution& s) -> std::vector<CheckedValue> {
            // Square root of the solver's tolerance, because the cost is flat.
            return {{"x(0)", s.trajectory.state(0.0)[0], -1.427572232082767, 1e-4, 16}};
          }};
}

}  // namespace saltus::library
