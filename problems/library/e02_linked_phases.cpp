// Links between phases that are not neighbours: the third phase must end one unit beyond the end of
// the first, and both have the same duration.
//
//   min int c u^2   x' = u   c = 1, 1, 2 in the three phases, 3 s in all
//   x(0) = 0, x(t1) = 1/2,  x(t3) = x(t1) + 1,  T3 = T1
//
// Within a phase u is constant. The second and the third phase share the distance 1 in the ratio T2
// : T3 / 2, which costs 1 / (T2 + T3 / 2). With T2 = 3 - 2 T1:
//
//   J = 1 / (4 T1) + 1 / (3 - 3 T1 / 2),   T1 = 3 / (3/2 + sqrt 6),
//   J = (3/2 + sqrt 6) (1/12 + 1 / (3 sqrt 6)).
//
// Guess: one second per phase, no input.
// Source: closed form.
#include <cmath>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Speed {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u;
  }
};

OptimalControlProblem problem() {
  const auto effort = [](double weight) {
    return [weight](const auto&, const auto&, const auto& u) { return weight * u[0] * u[0]; };
  };
  Phase<1, 1> there{"there", Speed{}, between(0.1, 2.0)};
  there.minimise("effort", effort(1.0))
      .reach(
          "place", [](const auto&, const auto& x) { return x[0]; }, exactly(0.5));
  Phase<1, 1> on{"on", Speed{}, between(0.1, 2.0)};
  on.minimise("effort", effort(1.0));
  Phase<1, 1> uphill{"uphill", Speed{}, between(0.1, 2.0)};
  uphill.minimise("effort", effort(2.0));
  for (auto* phase : {&there, &on, &uphill}) phase->guess_duration(1.0);

  OptimalControlProblem ocp("linked phases");
  ocp.start_at({0}).then(there).then(on).then(uphill).total_time(exactly(3.0));
  ocp.link(
      "one ahead", [](const auto& a, const auto& b) { return b.x[0] - a.x[0]; }, exactly(1.0),
      end_of(there), end_of(uphill));
  ocp.link(
      "equally long", [](const auto& a, const auto& b) { return b.duration - a.duration; },
      exactly(0.0), start_of(there), start_of(uphill));
  return ocp;
}

}  // namespace

ReferenceCase linked_phases() {
  const double root = std::sqrt(6.0), first = 3.0 / (1.5 + root);
  return {.id = "E02",
          .name = "linked_phases",
          .summary = "The third of three phases is linked to the first.",
          .states = {"place"},
          .inputs = {"speed"},
          .exercises = "links between the ends and the durations of phases that are not adjacent",
          .source = "closed form",
          .problem = problem,
          .options = {.intervals_per_phase = 5, .integrator = runge_kutta4()},
          .optimum = (1.5 + root) * (1.0 / 12.0 + 1.0 / (3.0 * root)),
          .digits = 15,
          .tolerance = 1e-9,  // tolerance of the solver; nothing is discretised
          .switching_times = {first, 3.0 - first}};
}

}  // namespace saltus::library
