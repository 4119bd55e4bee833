// A plugin with one controller: a cart moves to a target that the host sets, against air drag.
#include <saltus/c/register_controller.hpp>
#include <saltus/saltus.hpp>

using namespace saltus;

namespace {

struct Cart {  // x = (position m, speed m/s), u = force per mass m/s^2, p = target m
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>&) const {
    return {x[1], u[0] - 0.2 * x[1] * sqrt(x[1] * x[1] + 0.01)};
  }
};

RecedingHorizonController make_cart(ControllerOptions options) {
  const auto distance = [](auto, auto x, auto, auto p) { return x[0] - p[0]; };
  const auto speed = [](auto, auto x, auto, auto) { return x[1]; };
  const auto pull = [](auto, auto, auto u, auto) { return u[0]; };
  Phase<2, 1, 1> ahead{"ahead", Cart{}, exactly(1.0)};
  ahead.bound_input(0, between(-3.0, 3.0))
      .data("target", VectorXd::Zero(1))
      .track("distance", distance, VectorXd::Constant(1, 10.0))
      .track("speed", speed, VectorXd::Constant(1, 1.0))
      .track("effort", pull, VectorXd::Constant(1, 0.1));
  OptimalControlProblem problem("cart");
  problem.start_at({0.0, 0.0}).then(ahead);
  options.period = 0.02;
  return {MultipleShooting(problem, {.intervals_per_phase = 25, .integrator = runge_kutta4()}),
          options};
}

const RegisterController cart("cart", make_cart);

}  // namespace
