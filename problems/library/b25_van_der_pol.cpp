// Van der Pol's oscillator is damped by an input with an active lower bound.
//
//   min int_0^5 x1^2 + x2^2 + u^2   x1' = (1 - x2^2) x1 - x2 + u, x2' = x1
//   x(0) = (0, 1), -0.3 <= u <= 1
//
// The input begins at its lower bound, rises, stays at its upper bound, and decays. These are four
// phases of free duration, so no piece of the input bends where a bound becomes inactive.
// Guess: the constant start, no input, phases of equal duration.
// Source: TOMLAB PROPT, "Van der Pol oscillator", which finds 2.8672595; the reference comes from
// indirect shooting.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double lower = -0.3, upper = 1.0;  // bounds of the input

struct Oscillator {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {(1.0 - x[1] * x[1]) * x[0] - x[1] + u[0], x[0]};
  }
};

OptimalControlProblem problem() {
  const auto cost = [](const auto&, const auto& x, const auto& u) {
    return x[0] * x[0] + x[1] * x[1] + u[0] * u[0];
  };
  const Bounds part = between(0.01, 5.0);  // s

  Phase<2, 1> low{"at the lower bound", Oscillator{}, part};
  low.bound_input(0, exactly(lower));
  Phase<2, 1> rise{"rise", Oscillator{}, part};
  rise.bound_input(0, between(lower, upper));
  Phase<2, 1> high{"at the upper bound", Oscillator{}, part};
  high.bound_input(0, exactly(upper));
  Phase<2, 1> fade{"fade", Oscillator{}, part};
  fade.bound_input(0, between(lower, upper));

  OptimalControlProblem ocp("Van der Pol");
  ocp.start_at({0, 1});
  for (auto* phase : {&low, &rise, &high, &fade}) {
    phase->inputs(InputParametrisation::piecewise_linear_continuous).minimise("cost", cost);
    ocp.then(phase->guess_duration(1.25));
  }
  ocp.total_time(exactly(5.0));
  return ocp;
}

}  // namespace

ReferenceCase van_der_pol() {
  return {.id = "B25",
          .name = "van_der_pol",
          .summary = "Van der Pol's oscillator is damped by a bounded input.",
          .states = {"x1", "x2"},
          .inputs = {"u"},
          .exercises = "inputs at their bounds in phases of free duration, an integrated cost",
          .source = "TOMLAB PROPT, Van der Pol oscillator; optimum by indirect shooting",
          .problem = problem,
          .options = {.intervals = {2, 15, 4, 40}, .integrator = runge_kutta8()},
          .optimum = 2.86726105,
          .digits = 9,
          .tolerance = 2e-7};  // piecewise linear inputs cost an excess of order h^4
}

}  // namespace saltus::library
