#include "problem.hpp"

#include <numbers>
#include <saltus/ocp/phase.hpp>

using namespace saltus;

namespace {

constexpr double gravity = 9.81;  // m/s^2
constexpr double mass = 1.0;      // kg
constexpr double length = 1.0;    // m
constexpr double friction = 0.1;  // N m s
constexpr double upright = std::numbers::pi;

struct Pendulum {  // x = (angle rad from hanging, rate rad/s), u = torque N m
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    const S torque = u[0] - friction * x[1] - mass * gravity * length * sin(x[0]);
    return {x[1], torque / (mass * length * length)};
  }
};

}  // namespace

OptimalControlProblem make_problem() {
  const auto state = [](auto, auto x) { return x; };
  const auto torque = [](auto, auto, auto u) { return u[0]; };

  Phase<2, 1> swing{"swing", Pendulum{}, exactly(3.0)};
  swing.bound_input(0, between(-6.0, 6.0))
      .reach("upright and at rest", state, std::vector<Bounds>{exactly(upright), exactly(0.0)})
      .track("effort", torque, VectorXd::Constant(1, 1.0));

  OptimalControlProblem problem("swing-up");
  problem.start_at({0.0, 0.0}).then(swing);
  return problem;
}
