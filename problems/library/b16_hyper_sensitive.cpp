// A hyper-sensitive problem: two short transients at the ends, nearly independent of each other,
// and a long time at rest between them.
//
//   min 1/2 int_0^10000 x^2 + u^2   x' = -x^3 + u   x(0) = 1, x(10000) = 1.5
//
// The Hamiltonian is zero, u = x^3 -+ x sqrt(1 + x^4), and the costs of the two transients add up:
// J = V_s(1) + V_u(1.5) with V(x) = [x^2 sqrt(1 + x^4) + asinh x^2] / 4 -+ x^4 / 4. Phases of given
// duration adapt the grid to the time scales: 4 s and 16 s to settle, a long rest in a few
// intervals (|x| < 1e-8), and 18 s and 2 s to depart.
// Guess: x = 0 throughout, no input.
// Source: Rao and Mease 1999; Patterson and Rao, GPOPS-II, which finds 6.7241 without the factor
// 1/2.
#include <cmath>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Decay {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    return Vec<S, 1>{u[0] - x[0] * x[0] * x[0]};
  }
};

OptimalControlProblem problem() {
  const auto cost = [](const auto&, const auto& x, const auto& u) {
    return 0.5 * (x[0] * x[0] + u[0] * u[0]);
  };
  const auto position = [](const auto&, const auto& x) { return x[0]; };

  Phase<1, 1> leave{"leave", Decay{}, exactly(4.0)};
  Phase<1, 1> settle{"settle", Decay{}, exactly(16.0)};
  Phase<1, 1> rest{"rest", Decay{}, exactly(10000.0 - 40.0)};
  Phase<1, 1> depart{"depart", Decay{}, exactly(18.0)};
  Phase<1, 1> arrive{"arrive", Decay{}, exactly(2.0)};
  arrive.reach("end", position, exactly(1.5));

  // State and input are tiny in this phase, and a change of the input acts for an hour.
  rest.nominal(Vec<double, 1>{1e-2}, Vec<double, 1>{1e-6});

  OptimalControlProblem ocp("hyper-sensitive");
  ocp.start_at({1});
  for (auto* phase : {&leave, &settle, &rest, &depart, &arrive}) {
    phase->inputs(InputParametrisation::piecewise_linear_continuous)
        .minimise("cost", cost)
        .guess_state(Guess::constant(Vec<double, 1>{0}));
    ocp.then(*phase);
  }
  return ocp;
}

std::vector<CheckedValue> more(const Solution& solution) {
  const auto input = [](double x, int sign) {
    return x * x * x + sign * x * std::sqrt(1 + std::pow(x, 4));
  };
  const Trajectory& trajectory = solution.trajectory;
  // Piecewise linear u with h = 1/10 s and 1/50 s has an error of up to h^2 |u''| / 8,
  // with u'' = 1.6 and 500.
  return {{"u(0)", trajectory.input(0.0)[0], input(1.0, -1), 2e-3, 16},
          {"u(T)", trajectory.input(trajectory.end_time())[0], input(1.5, 1), 2.5e-2, 16},
          {"x(T/2)", trajectory.state(5000.0)[0], 0.0, 1e-7, 16}};
}

}  // namespace

ReferenceCase hyper_sensitive() {
  return {.id = "B16",
          .name = "hyper_sensitive",
          .summary = "Two short transients with a long steady time between them.",
          .states = {"x"},
          .inputs = {"u"},
          .exercises = "time scales of 1 s and 10,000 s, a grid graded by phases",
          .source = "Rao and Mease 1999; closed form",
          .problem = problem,
          .options = {.intervals = {40, 40, 4, 45, 100}, .integrator = runge_kutta8()},
          .optimum = 3.362056904943002,
          .digits = 16,
          .tolerance = 1e-6,  // piecewise linear inputs cost an excess of order h^4: 4e-7
          .more = more};
}

}  // namespace saltus::library
