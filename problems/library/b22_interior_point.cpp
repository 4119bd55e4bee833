// A trajectory through a given point: the state passes 0.9 at t = 0.75 on its way from 1 to 0.75.
//
//   min int x^2 + u^2   x' = u   x(0) = 1, x(0.75) = 0.9, x(1) = 0.75
//
// Closed form: between two points a and b at a distance T in time, x is a combination of sinh and
// cosh, and the cost is ((a^2 + b^2) cosh T - 2 a b) / sinh T. The input jumps at the point: it is
// an event.
// Guess: the constant start, no input.
// Source: Becerra, PSOPT examples ("interior point constraint"), which finds 0.9205314.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Velocity {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u;
  }
};

OptimalControlProblem problem() {
  const auto cost = [](const auto&, const auto& x, const auto& u) {
    return x[0] * x[0] + u[0] * u[0];
  };
  const auto position = [](const auto&, const auto& x) { return x[0]; };

  Phase<1, 1> before{"to the point", Velocity{}, exactly(0.75)};
  before.minimise("cost", cost).reach("point", position, exactly(0.9));

  Phase<1, 1> after{"to the end", Velocity{}, exactly(0.25)};
  after.minimise("cost", cost).reach("end", position, exactly(0.75));

  for (auto* phase : {&before, &after})
    phase->inputs(InputParametrisation::piecewise_linear_continuous);
  OptimalControlProblem ocp("interior point");
  ocp.start_at({1}).then(before).then(after);
  return ocp;
}

}  // namespace

ReferenceCase interior_point() {
  return {.id = "B22",
          .name = "interior_point",
          .summary = "A state must pass through a given point.",
          .states = {"x"},
          .inputs = {"u"},
          .exercises = "a condition between two phases, an input that jumps there",
          .source = "PSOPT examples, interior point; closed form",
          .problem = problem,
          .options = {.intervals = {60, 20}, .integrator = runge_kutta8()},
          .optimum = 0.920531441473003,
          .digits = 15,
          // Piecewise linear inputs with h = 1/80 s cost an excess of order h^4.
          .tolerance = 1e-9};
}

}  // namespace saltus::library
