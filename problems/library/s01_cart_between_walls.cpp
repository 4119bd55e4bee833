// A pole on a cart balances between two soft walls on which it may lean. The contacts with the
// walls determine the dynamics.
//
//   p'' = (m g theta + u) / M,  theta'' = ((M + m) g theta + u) / (M l) - F / (m l)
//   tip y = p - l theta,   |u| <= 1 N, |p| <= 0.5 m, |theta| <= pi/10, |p'|, |theta'| <= 2
//   free |y| <= d: F = 0;   right y >= d: F = -k (y - d) - c y';   left: the mirror image
//   min sum_k h/2 (|x_k|^2 + u_k^2) + 1/2 x_N' P x_N
//
// M = m = 1 kg, l = 1 m, g = 10 m/s^2, d = 0.5 m, k = 100 N/m, c = 5 N s/m, h = 0.1 s. The input is
// held, and the flow of each mode is exact. P solves the Riccati equation of the free mode,
// rounded.
// Source: after T. Marcucci and R. Tedrake, Mixed-integer formulations for optimal control of
// piecewise-affine systems (2019), and Warm start of mixed-integer programs for model predictive
// control of hybrid systems (2021). The numbers are our own.
#include <numbers>

#include "problems/library/mode_graphs.hpp"

namespace saltus::library {
namespace {

constexpr double cart = 1.0, pole = 1.0;    // kg
constexpr double length = 1.0, wall = 0.5;  // m
constexpr double gravity = 10.0;            // m/s^2
constexpr double stiffness = 100.0;         // N/m
constexpr double damping = 5.0;             // N s/m
constexpr double sample = 0.1;              // s

enum class Touches { nothing, right, left };

struct CartPole {
  Touches touches;

  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& u) const {
    const S tip = x[0] - length * x[1], rate = x[2] - length * x[3];
    S force = 0.0 * tip;
    if (touches == Touches::right) force = -stiffness * (tip - wall) - damping * rate;
    if (touches == Touches::left) force = -stiffness * (tip + wall) - damping * rate;
    return {x[2], x[3], (pole * gravity * x[1] + u[0]) / cart,
            ((cart + pole) * gravity * x[1] + u[0]) / (cart * length) - force / (pole * length)};
  }
};

Phase<4, 1> mode(const char* name, Touches touches, Bounds tip) {
  Phase<4, 1> phase{name, CartPole{touches}, exactly(sample)};
  phase
      .begin_with(
          "tip", [](const auto&, const auto& x) { return x[0] - length * x[1]; }, tip)
      .bound_input(0, between(-1.0, 1.0))
      .bound_state(0, between(-wall, wall))
      .bound_state(1, between(-std::numbers::pi / 10.0, std::numbers::pi / 10.0))
      .bound_state(2, between(-2.0, 2.0))
      .bound_state(3, between(-2.0, 2.0))
      .track(
          "state", [](const auto&, const auto& x) { return x; }, VectorXd::Ones(4))
      .track(
          "effort", [](const auto&, const auto&, const auto& u) { return u; }, VectorXd::Ones(1));
  return phase;
}

}  // namespace

ModeGraph cart_between_walls(const VectorXd& start) {
  const auto cost_to_go = [](const auto&, const auto& x) {
    const Mat<double, 4, 4> P{{2.7759, -13.1622, 3.2139, -4.2597},
                              {-13.1622, 319.1374, -31.5828, 84.9549},
                              {3.2139, -31.5828, 7.4944, -10.2841},
                              {-4.2597, 84.9549, -10.2841, 23.6365}};
    auto cost = 0.0 * x[0];
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) cost += 0.5 * P(i, j) * x[i] * x[j];
    return cost;
  };
  ModeGraph graph("cart between walls");
  graph.mode(mode("free", Touches::nothing, between(-wall, wall)))
      .mode(mode("right", Touches::right, at_least(wall)))
      .mode(mode("left", Touches::left, at_most(-wall)))
      .all_transitions()
      .minimise_at_end<4>("cost to go", cost_to_go)
      .costs(CostRule::nodes)  // discrete time, as in the papers
      .start_at(start);
  return graph;
}

}  // namespace saltus::library
