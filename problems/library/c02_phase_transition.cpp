// A fast slide is braked and then steered by its velocity: the state loses a dimension between the
// two phases. Ten intervals of 0.04 s, then fifteen of 0.04 s.
//
//   phase 1   p' = v, v' = a, |a| <= 50    cost 1/2 (p^2 + 0.1 v^2 + 0.001 a^2)
//   passage   (p, v) -> p                  cost 1/2 (p^2 + 0.01 v^2), once
//   phase 2   p' = u, |u| <= 5             cost 1/2 (p^2 + 0.1 u^2), at the end 1/2 10 p^2
//
// Costs are summed at the nodes: each is multiplied by the length of the interval that starts
// there.
// Guess: the constant start, no input.
// Source: acados, examples/acados_python/mocp_transition_example, with the transition at 0.4 s. The
// example prints no value; the reference was computed independently.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Acceleration {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& a) const {
    return {x[1], a[0]};
  }
};

struct Velocity {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u;
  }
};

OptimalControlProblem problem() {
  const auto state = [](const auto&, const auto& x) { return x; };
  const auto input = [](const auto&, const auto&, const auto& u) { return u; };

  Phase<2, 1> slide{"slide", Acceleration{}, exactly(0.4)};
  slide.bound_input(0, between(-50.0, 50.0))
      .track("state", state, Vec<double, 2>{1.0, 0.1})
      .track("acceleration", input, Vec<double, 1>{1e-3})
      .minimise_at_end("passage", [](const auto&, const auto& x) {
        return 0.5 * (x[0] * x[0] + 0.01 * x[1] * x[1]);
      });

  Phase<1, 1> steer{"steer", Velocity{}, exactly(0.6)};
  steer.bound_input(0, between(-5.0, 5.0))
      .track("position", state, Vec<double, 1>{1.0})
      .track("velocity", input, Vec<double, 1>{0.1})
      .track_at_end("at the end", state, Vec<double, 1>{10.0});

  OptimalControlProblem ocp("phase transition");
  ocp.start_at({2, 0}).then(slide).then(
      steer, jump<2>("drop the velocity", [](const auto&, const auto& x) { return x[0]; }));
  ocp.costs(CostRule::nodes);  // as published
  return ocp;
}

}  // namespace

ReferenceCase phase_transition() {
  return {.id = "C02",
          .name = "phase_transition",
          .summary =
              "A fast slide is braked, then steered by its velocity: the state loses a dimension.",
          .states = {"position", "velocity"},
          .inputs = {"acceleration, then velocity"},
          .exercises = "different state dimensions, a jump, a cost of the transition, node costs",
          .source = "acados, mocp_transition_example; optimum computed independently",
          .problem = problem,
          .options = {.intervals = {10, 15}, .integrator = runge_kutta4()},  // exact: quadratic
          .optimum = 1.025208314701,
          .digits = 13,
          .tolerance = 1e-9};  // tolerance of the solver; rounding costs 5e-13
}

}  // namespace saltus::library
