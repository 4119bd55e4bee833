// Swing-up of a pendulum on a cart: the program that docs/coming_from.md compares with acados.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <saltus/saltus.hpp>

using namespace saltus;

struct CartPole {  // x = (position m, angle rad, speed m/s, angular speed rad/s), u = force N
  double M = 1.0, m = 0.1, l = 0.8, g = 9.81;  // kg, kg, m, m/s^2
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& u) const {
    const S s = sin(x[1]), c = cos(x[1]), w = x[3], F = u[0];
    const S mass = M + m - m * c * c;
    return {x[2], w, (-m * l * s * w * w + m * g * c * s + F) / mass,
            (-m * l * c * s * w * w + F * c + (M + m) * g * s) / (l * mass)};
  }
};

int main() {
  const Vec<double, 4> Q{2e3, 2e3, 2e-2, 2e-2};
  const Vec<double, 1> R{2e-2};
  const Vec<double, 4> hanging{0, std::numbers::pi, 0, 0}, upright{0, 0, 0, 0};
  const auto state = [](auto, auto x) { return x; };
  const auto force = [](auto, auto, auto u) { return u; };

  Phase<4, 1> swing{"swing up", CartPole{}, exactly(1.0)};
  swing.track("state", state, Q)
      .track("force", force, R)
      .track_at_end("final state", state, Q)
      .bound_input(0, between(-80.0, 80.0))
      .guess_state(Guess::interpolate(hanging, upright));

  OptimalControlProblem problem("pendulum on a cart");
  problem.start_at(hanging).then(swing).costs(CostRule::nodes);

  MultipleShooting shooting{problem,
                            {.intervals_per_phase = 20, .integrator = runge_kutta4({.steps = 10})}};
  const std::unique_ptr<Solver> solver = make_native_solver({.qp = riccati_qp()});
  const Solution plan = solve(shooting, *solver);
  std::printf("%s\ncost %.2f, first force %.2f N\n", plan.message.c_str(), plan.cost,
              plan.trajectory.input(0.0)[0]);
  return plan.ok() && std::abs(plan.cost - 2242.166425) < 1e-6 ? 0 : 1;
}
