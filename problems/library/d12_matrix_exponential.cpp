// A linear system that switches once, and its quadratic cost, from matrix exponentials alone.
//
//   x' = A1 x until tau, then x' = A2 x    A1 = [-1 0; 1 2], A2 = [1 1; 1 -2]
//   J = int_0^1 x'x dt                     x(0) = (1, 1)
//
// exp([-A', Q; 0, A] t) = [., G12; 0, F] gives the flow F and the Gram matrix F'G12, so that int
// x'Qx dt = x0' F'G12 x0. The derivative of J with respect to tau vanishes at the optimal tau.
// Source: Van Loan, IEEE TAC 23 (1978) 395-404; system and optimal tau from Egerstedt, Wardi and
// Axelsson, IEEE TAC 51 (2006) 110-115, and SwitchTimeOpt.jl, test/linsys.jl, with more digits.
#include "problems/library/initial_value_problems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"
#include "saltus/integrators/zero_order_hold.hpp"

namespace saltus::library {
namespace {

constexpr double rounding = 1e-13;  // relative; a few products of matrices

struct First {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x) const {
    return {-x[0], x[0] + 2.0 * x[1]};
  }
};

struct Second {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x) const {
    return {x[0] + x[1], x[0] - 2.0 * x[1]};
  }
};

template <class Dynamics>
std::unique_ptr<Integrator> exact_flow(const Dynamics& dynamics) {
  IntervalProblem problem;
  problem.arguments = {2, 0, 0};
  problem.dynamics = make_function<2, 0, 0>(dynamics);
  problem.running_cost =
      make_function<2, 0, 0>([](const auto&, const auto& x) { return x[0] * x[0] + x[1] * x[1]; });
  problem.differentiate_time = true;
  return zero_order_hold()->make(problem);
}

struct Outcome {
  double cost, slope;  // J, dJ/dtau
  VectorXd at_switch;
};

Outcome switched_at(double tau) {
  const auto before = exact_flow(First{}), after = exact_flow(Second{});
  // w = (x | t0 | h), results (x | J).
  const VectorXd w1 = (VectorXd(4) << 1.0, 1.0, 0.0, tau).finished();
  const VectorXd end1 = integrate(*before, w1);
  const VectorXd w2 = (VectorXd(4) << end1[0], end1[1], tau, 1.0 - tau).finished();
  const VectorXd end2 = integrate(*after, w2);
  const MatrixXd d1 = sensitivities(*before, w1), d2 = sensitivities(*after, w2);
  const double slope = d1(2, 3) + d2.block(2, 0, 1, 2).row(0).dot(d1.col(3).head(2)) - d2(2, 3);
  return {end1[2] + end2[2], slope, end1.head(2)};
}

std::vector<CheckedValue> run() {
  const Outcome best = switched_at(0.26486609904077944), half = switched_at(0.5);
  return {{"J at the best tau", best.cost, 5.2545429449232242, rounding * 5.25, 17},
          residual_of("dJ/dtau at the best tau", best.slope, 1e-12),
          {"J at 0.5", half.cost, 7.0335958076682, rounding * 7.03, 14},
          {"dJ/dtau at 0.5", half.slope, 15.9805362377523, rounding * 15.98, 15},
          {"x1(0.5)", half.at_switch[0], 0.60653066, 5e-9, 8},  // half a unit of the last digit
          {"x2(0.5)", half.at_switch[1], 3.42219888, 5e-9, 9}};
}

IntervalProblem flow(Function dynamics) {
  IntervalProblem problem;
  problem.arguments = {2, 0, 0};
  problem.dynamics = std::move(dynamics);
  return problem;
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  const IntegratorChoice used = scheme ? scheme : zero_order_hold();
  const double tau = 0.26486609904077944;
  Motion motion = simulate_motion(flow(make_function<2, 0, 0>(First{})), used, VectorXd::Ones(2),
                                  even_times(0.0, tau, 50));
  const VectorXd at_switch = motion.recording.samples.back().state;
  const Motion second = simulate_motion(flow(make_function<2, 0, 0>(Second{})), used, at_switch,
                                        even_times(tau, 1.0, 150));
  for (Sample& sample : motion.recording.samples) sample.mode = "A1";
  for (Sample sample : second.recording.samples) {
    sample.mode = "A2";
    motion.recording.samples.push_back(std::move(sample));
  }
  motion.recording.events.push_back(
      {tau, HybridEvent::Kind::crosses, "switch", "A1", "A2", at_switch, at_switch, {}});
  motion.recording.state_names = {"x1", "x2"};
  return {motion};
}

}  // namespace

SimulationCase matrix_exponential() {
  return {.id = "D12",
          .name = "matrix_exponential",
          .summary = "A linear system with one switch, by matrix exponentials alone.",
          .exercises = "exact zero-order hold: flow, cost and slope in a switching time",
          .source = "Van Loan 1978; Egerstedt, Wardi and Axelsson 2006, computed independently",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
