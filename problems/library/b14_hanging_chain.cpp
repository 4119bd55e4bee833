// A chain of given length hangs between two points. The shape minimises the height of its centre of
// mass.
//
//   min int_0^1 x sqrt(1 + u^2)   x' = u   x(0) = 1, x(1) = 3, int_0^1 sqrt(1 + u^2) = 4
//
// The optimum is a catenary x = c cosh((t - t0) / c) + shift with c = 0.163697529524834. The length
// is a state.
// Guess: x linear between its ends, u from -2 to 6.
// Source: Dolan, More and Munson, COPS 3.0, hanging chain; closed form.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Chain {  // x = (height, length so far), u = slope
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>&, const Vec<S, 1>& u) const {
    return {u[0], sqrt(1.0 + u[0] * u[0])};
  }
};

OptimalControlProblem problem() {
  const auto height = [](const auto&, const auto& x) { return x[0]; };
  const auto length = [](const auto&, const auto& x) { return x[1]; };
  Phase<2, 1> chain{"chain", Chain{}, exactly(1.0)};
  chain
      .minimise("height", [](const auto&, const auto& x,
                             const auto& u) { return x[0] * sqrt(1.0 + u[0] * u[0]); })
      .reach("end", height, exactly(3.0))
      .reach("length", length, exactly(4.0))
      .inputs(InputParametrisation::piecewise_linear_continuous)
      .guess_state(Guess::interpolate(Vec<double, 2>{1, 0}, Vec<double, 2>{3, 4}))
      .guess_input(Guess::interpolate(Vec<double, 1>{-2}, Vec<double, 1>{6}));
  OptimalControlProblem ocp("hanging chain");
  ocp.start_at({1, 0}).then(chain);
  return ocp;
}

ReferenceCase with_intervals(int intervals, double tolerance) {
  ReferenceCase c;
  c.states = {"height", "length"};
  c.inputs = {"slope"};
  c.exercises = "an integral constraint";
  c.source = "COPS 3.0, hanging chain; closed form";
  c.problem = problem;
  c.options = {.intervals_per_phase = intervals, .integrator = runge_kutta8()};
  c.optimum = 5.06848011099342;
  c.digits = 15;
  c.tolerance = tolerance;
  return c;
}

}  // namespace

// A piecewise linear slope costs an excess of order h^4.
ReferenceCase hanging_chain() {
  ReferenceCase c = with_intervals(40, 1e-6);
  c.id = "B14a";
  c.name = "hanging_chain";
  c.summary = "A chain of given length hangs between two points.";
  return c;
}

ReferenceCase hanging_chain_fine() {
  ReferenceCase c = with_intervals(160, 1e-6);
  c.id = "B14b";
  c.name = "hanging_chain_fine";
  c.summary = "The same problem on a finer grid.";
  return c;
}

}  // namespace saltus::library
