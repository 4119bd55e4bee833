// Swing-up of a pendulum on a cart in one second, with twenty intervals of constant force.
//
//   x = (p, theta, v, w), theta = 0 upright      u = F, |F| <= 80 N
//   min sum_k 0.05 * 1/2 (x_k' Q x_k + R F_k^2) + 1/2 x_N' Q x_N
//
// Costs are summed at the nodes. The problem has many local minima: from another guess solvers end
// at 3928.8 and elsewhere. The guess is part of the case: theta decreases linearly from pi to 0,
// and everything else is zero. docs/coming_from.md compares this problem with acados.
// Source: acados, examples/acados_python/pendulum_on_cart; the optimum was computed independently.
#include <numbers>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct CartPole {
  double cart = 1.0;      // kg
  double bob = 0.1;       // kg
  double length = 0.8;    // m
  double gravity = 9.81;  // m/s^2

  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& u) const {
    const S s = sin(x[1]), c = cos(x[1]), w = x[3], force = u[0];
    const S mass = cart + bob - bob * c * c;
    const S a = (-bob * length * s * w * w + bob * gravity * c * s + force) / mass;
    const S b =
        (-bob * length * c * s * w * w + force * c + (cart + bob) * gravity * s) / (length * mass);
    return {x[2], w, a, b};
  }
};

OptimalControlProblem problem() {
  const auto state = [](const auto&, const auto& x) { return x; };
  const auto force = [](const auto&, const auto&, const auto& u) { return u; };
  const Vec<double, 4> Q{2e3, 2e3, 2e-2, 2e-2};
  const Vec<double, 4> hanging{0, std::numbers::pi, 0, 0}, upright{0, 0, 0, 0};

  Phase<4, 1> swing{"swing up", CartPole{}, exactly(1.0)};
  swing.bound_input(0, between(-80.0, 80.0))
      .track("state", state, Q)
      .track("force", force, Vec<double, 1>{0.02})
      .track_at_end("at the end", state, Q)
      .guess_state(Guess::interpolate(hanging, upright));
  OptimalControlProblem ocp("pendulum on cart");
  ocp.start_at(hanging).then(swing).costs(CostRule::nodes);  // as published
  return ocp;
}

}  // namespace

ReferenceCase pendulum_on_cart() {
  return {.id = "C03",
          .name = "pendulum_on_cart",
          .summary = "Swing-up of a pendulum on a cart in one second.",
          .states = {"position [m]", "angle [rad]", "speed [m/s]", "angular speed [rad/s]"},
          .inputs = {"force [N]"},
          .exercises = "nonlinear dynamics, an interpolated guess among local minima, node costs",
          .source = "acados, pendulum_on_cart; optimum computed independently",
          .problem = problem,
          // Ten steps of order eight per interval: the replay confirms an accuracy of 1e-11.
          .options = {.intervals_per_phase = 20, .integrator = runge_kutta8({.steps = 10})},
          .optimum = 2242.166366,
          .digits = 9,
          .tolerance = 3e-9};  // half a unit of the ninth digit
}

}  // namespace saltus::library
