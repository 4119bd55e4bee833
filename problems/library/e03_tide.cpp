// A free start time: a crossing of one hour in a current that changes with the time of day.
//
//   min int u^2   x' = u + cos t   x(t0) = 0, x(t0 + 1) = 2, t0 free
//
// u is constant and has to supply the rest of the distance, 2 - (sin(t0 + 1) - sin t0). It is
// smallest at t0 = -1/2, where the current helps most: J = (2 - 2 sin(1/2))^2.
// Guess: t0 = 1/2, the constant start, no input.
// Source: closed form.
#include <cmath>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Current {
  template <class S>
  Vec<S, 1> operator()(const S& t, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    using std::cos;
    return Vec<S, 1>{u[0] + cos(t)};
  }
};

OptimalControlProblem problem() {
  Phase<1, 1> crossing{"crossing", Current{}, exactly(1.0)};
  crossing.minimise("effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; })
      .reach(
          "shore", [](const auto&, const auto& x) { return x[0]; }, exactly(2.0));
  OptimalControlProblem ocp("tide");
  ocp.start_at({0}).start_time(between(-2.0, 2.0), 0.5).then(crossing);
  return ocp;
}

}  // namespace

ReferenceCase tide() {
  const double help = 2.0 * std::sin(0.5);
  return {.id = "E03",
          .name = "tide",
          .summary = "A crossing starts when the current is most favourable.",
          .states = {"x"},
          .inputs = {"u"},
          .exercises = "a free start time",
          .source = "closed form",
          .problem = problem,
          .options = {.intervals_per_phase = 10, .integrator = runge_kutta8()},
          .optimum = (2.0 - help) * (2.0 - help),
          .digits = 15,
          .tolerance = 1e-9,  // tolerance of the solver; constant inputs are optimal
          .more = [](const Solution& s) -> std::vector<CheckedValue> {
            return {{"start time", s.trajectory.start_time(), -0.5, 1e-5}};
          }};
}

}  // namespace saltus::library
