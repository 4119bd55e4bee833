// Delays in state and input: the derivative depends on the state one second ago and the input two
// seconds ago.
//
//   min int_0^3 x^2 + u^2   x'(t) = x(t - 1) u(t - 2)   x = 1, u = 0 for t <= 0
//
// The method of steps: one phase of one second has three states and three inputs, x_i(s) = x(s +
// i), one per second of the problem. Links join the end of each history to the start of the next:
//
//   x_0' = 0, x_1' = 0, x_2' = x_1 u_0,   x_1(0) = x_0(1), x_2(0) = x_1(1).
//
// x is 1 until t = 2, and then x_2' = u_0: J = 2 + tanh 1, u_0 = -sinh(1 - s) / cosh 1.
// Guess: x = 1, no input.
// Source: Goellmann, Kern, Maurer, Optim. Control Appl. Meth. 30, 2009, section 4 (2.76159416).
#include <cmath>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Steps {
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 3>& u) const {
    return {S(0.0), S(0.0), x[1] * u[0]};
  }
};

OptimalControlProblem problem() {
  Phase<3, 3> second{"second", Steps{}, exactly(1.0)};
  second
      .minimise("cost", [](const auto&, const auto& x,
                           const auto& u) { return x.squaredNorm() + u.squaredNorm(); })
      .inputs(InputParametrisation::piecewise_linear_continuous)
      .guess_state(Guess::constant(Vec<double, 3>::Ones()));
  OptimalControlProblem ocp("delayed product");
  ocp.start_within({exactly(1.0), unbounded(), unbounded()}, Vec<double, 3>::Ones()).then(second);
  ocp.link(
      "history",
      [](const auto& start, const auto& end) {
        auto gap = start.x.template head<2>().eval();
        for (int i = 0; i < 2; ++i) gap[i] = start.x[i + 1] - end.x[i];
        return gap;
      },
      exactly(0.0), start_of(second), end_of(second));
  return ocp;
}

}  // namespace

ReferenceCase delayed_product() {
  return {.id = "E04",
          .name = "delayed_product",
          .summary = "A system whose dynamics depend on past states and inputs.",
          .states = {"x(s)", "x(s + 1)", "x(s + 2)"},
          .inputs = {"u(s)", "u(s + 1)", "u(s + 2)"},
          .exercises = "delays as histories in the state, joined by links",
          .source = "Goellmann, Kern, Maurer, Optim. Control Appl. Meth. 30, 2009; closed form",
          .problem = problem,
          .options = {.intervals_per_phase = 50, .integrator = runge_kutta8()},
          .optimum = 2.0 + std::tanh(1.0),
          .digits = 15,
          // Piecewise linear inputs with h = 1/50 s cost an excess of order h^4.
          .tolerance = 1e-8};
}

}  // namespace saltus::library
