// Two catalysts are mixed along a tube to maximise the yield of the third substance. The optimum
// uses the first catalyst, then a constant mixture (a singular arc), then the second one.
//
//   min -1 + x1(1) + x2(1)   x1' = u (10 x2 - x1), x2' = u (x1 - 10 x2) - (1 - u) x2, 0 <= u <= 1
//   x(0) = (1, 0), t along the tube
//
// On the arc the mixture stays 5 % away from its bounds. At a bound this phase could replace its
// neighbours, and solvers could converge to neighbours of minimum length.
// Guess: the constant start, an even mixture on the arc, a third of the tube per phase.
// Source: COPS 3.0, catmix: -0.0480556; further digits were computed independently.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Reactions {  // x = fractions of the first two substances, u = fraction of the first catalyst
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    const S exchange = u[0] * (10.0 * x[1] - x[0]);
    return {exchange, -exchange - (1.0 - u[0]) * x[1]};
  }
};

OptimalControlProblem problem() {
  const auto minus_product = [](const auto&, const auto& x) { return x[0] + x[1] - 1.0; };
  const Bounds part = between(0.01, 0.98);  // fraction of the tube

  Phase<2, 1> first{"first catalyst", Reactions{}, part}, mixed{"mixed", Reactions{}, part};
  Phase<2, 1> second{"second catalyst", Reactions{}, part};
  first.bound_input(0, exactly(1.0));
  mixed.bound_input(0, between(0.05, 0.95)).guess_input(Guess::constant(Vec<double, 1>{0.5}));
  second.bound_input(0, exactly(0.0)).minimise_at_end("product", minus_product);

  OptimalControlProblem ocp("catalyst mixing");
  ocp.start_at({1, 0});
  for (auto* phase : {&first, &mixed, &second}) {
    phase->guess_duration(1.0 / 3.0);
    ocp.then(*phase);
  }
  ocp.total_time(exactly(1.0));
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  return {{"u on the arc", s.trajectory.input(0.4)[0], 0.22712, 1e-4, 5}};
}

}  // namespace

ReferenceCase catalyst_mixing() {
  return {.id = "B10",
          .name = "catalyst_mixing",
          .summary = "The mixture of two catalysts along a tube that maximises the yield.",
          .states = {"substance 1", "substance 2"},
          .inputs = {"first catalyst"},
          .exercises = "bang, singular, bang: two free switches and a singular input",
          .source = "COPS 3.0, catmix; more digits computed independently",
          .problem = problem,
          .options = {.intervals_per_phase = 2, .integrator = runge_kutta8({.steps = 4})},
          .optimum = -0.048055685861,
          .digits = 11,
          .tolerance = 1e-9,  // tolerance of the solver; the mixture on the arc is constant
          .switching_times = {0.1362995, 0.7252268},
          .more = more};
}

}  // namespace saltus::library
