// Three carts are pulled towards 1. For each cart, a soft term penalises the remaining distance,
// with a different penalty and a different kind of term.
//
//   min int |u|^2 / 2 + P(v)   x' = u, x(0) = 0, one second, v = max(0, 1 - what is reached)
//
// Each cart has its own optimum:
//
//   L1, weight 2/5, of x(1), at the end of the phase:    u = 2/5              v = 3/5  cost 8/25
//   L2, weight 2, of x(1) - x(0), a link:                u = 2/3              v = 1/3  cost 1/3
//   Huber, weight 2 up to 1/4, of int x, an integral:    u = (1 - t) / 2      v = 5/6  cost 19/48
//
// Guess: at rest.
// Source: closed form.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Carts {
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>&, const Vec<S, 3>& u) const {
    return u;
  }
};

OptimalControlProblem problem() {
  Phase<3, 3> pull{"pull", Carts{}, exactly(1.0)};
  pull.minimise("effort",
                [](const auto&, const auto&, const auto& u) { return 0.5 * u.squaredNorm(); })
      .reach(
          "first", [](const auto&, const auto& x) { return x[0]; }, at_least(1.0),
          soft("first", 0.4))
      .bound_integral("third", [](const auto&, const auto& x) { return x[2]; },
                      {at_least(1.0), huber("third", 2.0, 0.25)})
      .inputs(InputParametrisation::piecewise_linear);
  OptimalControlProblem ocp("soft targets");
  ocp.start_at({0, 0, 0}).then(pull);
  ocp.link(
      "second", [](const auto& start, const auto& end) { return end.x[1] - start.x[1]; },
      {at_least(1.0), soft("second", 2.0, Penalty::L2)}, start_of(pull), end_of(pull));
  return ocp;
}

}  // namespace

ReferenceCase soft_targets() {
  return {.id = "E06",
          .name = "soft_targets",
          .summary = "Three penalties for missing a target.",
          .states = {"first", "second", "third"},
          .inputs = {"u1", "u2", "u3"},
          .exercises =
              "soft terms with L1, L2 and Huber penalties: at an end, on a link, on an integral",
          .source = "closed form",
          .problem = problem,
          .options = {.intervals_per_phase = 10, .integrator = runge_kutta4()},
          .optimum = 8.0 / 25.0 + 1.0 / 3.0 + 19.0 / 48.0,
          .digits = 15,
          .tolerance = 1e-8,  // tolerance of the solver
          .more = [](const Solution& s) -> std::vector<CheckedValue> {
            std::vector<CheckedValue> values;
            for (const Solution::SoftViolation& v : s.soft_violations)
              values.push_back({"missed by the " + v.term, v.largest,
                                v.term == "first"    ? 0.6
                                : v.term == "second" ? 1.0 / 3.0
                                                     : 5.0 / 6.0,
                                1e-6});
            return values;
          }};
}

}  // namespace saltus::library
