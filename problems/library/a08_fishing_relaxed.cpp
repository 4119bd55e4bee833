// Predators and prey are fished to keep both populations near 1, with a continuous effort between 0
// and 1. The optimum waits, fishes with full effort, and follows a singular arc to the end.
//
//   min int_0^12 (x1 - 1)^2 + (x2 - 1)^2      x(0) = (0.5, 0.7)
//   x1' = x1 - x1 x2 - 0.4 x1 w, x2' = -x2 + x1 x2 - 0.2 x2 w     0 <= w <= 1
//
// On the arc the effort stays 10 % below its bound. At the bound the third phase could replace the
// second one on a coarser grid, and solvers could converge to a second phase of minimum length.
// Guess: both populations at 1, no fishing, three phases of equal length.
// Source: Sager, mintOC.de, Lotka Volterra fishing problem, relaxed: 1.34408. Further digits were
// computed independently.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Populations {  // x = (prey, predators), w = effort
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& w) const {
    const S meeting = x[0] * x[1];
    return {x[0] - meeting - 0.4 * w[0] * x[0], -x[1] + meeting - 0.2 * w[0] * x[1]};
  }
};

OptimalControlProblem problem() {
  const auto deviation = [](const auto&, const auto& x) {
    const auto a = x[0] - 1.0, b = x[1] - 1.0;
    return a * a + b * b;
  };
  const Bounds part = between(0.1, 11.8);  // twelve time units in total

  Phase<2, 1> wait{"wait", Populations{}, part}, all{"fish", Populations{}, part};
  Phase<2, 1> singular{"singular", Populations{}, part};
  wait.bound_input(0, exactly(0.0));
  all.bound_input(0, exactly(1.0));
  singular.bound_input(0, between(0.0, 0.9))
      .inputs(InputParametrisation::piecewise_linear_continuous);

  OptimalControlProblem ocp("relaxed fishing");
  ocp.start_at({0.5, 0.7});
  for (auto* phase : {&wait, &all, &singular}) {
    phase->minimise("deviation", deviation)
        .guess_state(Guess::constant(Vec<double, 2>{1.0, 1.0}))
        .guess_duration(4.0);
    ocp.then(*phase);
  }
  ocp.total_time(exactly(12.0));
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  // The cost is insensitive to the start of the arc.
  return {{"t1", s.durations[0], 2.436700, 1e-4, 7},
          {"t2", s.durations[0] + s.durations[1], 3.941971, 1e-2, 3}};
}

}  // namespace

ReferenceCase fishing_relaxed() {
  return {
      .id = "A08",
      .name = "fishing_relaxed",
      .summary = "Predators and prey are fished with a continuous effort between none and full.",
      .states = {"prey", "predators"},
      .inputs = {"effort"},
      .exercises = "bang, bang, singular: two free switching times and a singular input",
      .source = "mintOC, relaxed; more digits computed independently",
      .problem = problem,
      .options = {.intervals = {8, 6, 20}, .integrator = runge_kutta8({.steps = 2})},
      .optimum = 1.344081198,
      .digits = 10,
      .tolerance = 1e-8,  // piecewise linear effort on the arc, and the last digit
      .more = more};
}

}  // namespace saltus::library
