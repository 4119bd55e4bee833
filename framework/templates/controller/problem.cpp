#include "problem.hpp"

#include <saltus/ocp/phase.hpp>

using namespace saltus;

namespace {

constexpr double gravity = 9.81;  // m/s^2
constexpr double cart = 1.0;      // kg
constexpr double bob = 0.2;       // kg, at the end of the pole
constexpr double length = 0.5;    // m

struct CartPole {  // x = (cart m, pole rad from upright, their rates), u = force on the cart, N
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& u, const Vec<S, 1>&) const {
    const S s = sin(x[1]), c = cos(x[1]);
    const S pull = bob * s * (length * x[3] * x[3] - gravity * c);
    const S acceleration = (u[0] + pull) / (cart + bob * s * s);
    return {x[2], x[3], acceleration, (gravity * s - acceleration * c) / length};
  }
};

}  // namespace

OptimalControlProblem make_problem() {
  const auto off = [](auto, auto x, auto, auto p) {
    return decltype(x){x[0] - p[0], x[1], x[2], x[3]};
  };
  const auto force = [](auto, auto, auto u, auto) { return u[0]; };

  Phase<4, 1, 1> balance{"balance", CartPole{}, exactly(1.0)};
  balance.data("target", VectorXd::Zero(1))
      .bound_input(0, between(-10.0, 10.0))
      .track("off the target", off, VectorXd{{10.0, 10.0, 1.0, 1.0}})
      .track_at_end("off the target at the end", off, VectorXd{{20.0, 50.0, 10.0, 5.0}})
      .track("effort", force, VectorXd::Constant(1, 0.01));

  OptimalControlProblem problem("balance");
  problem.start_at({0.0, 0.1, 0.0, 0.0}).then(balance);
  return problem;
}
