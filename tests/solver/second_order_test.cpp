// Saddles and maxima are not called optima, and flat optima are not called saddles.
#include "saltus/solver/second_order.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/sqp.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

struct Integrator1 {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return Vec<S, 1>(u[0]);
  }
};

template <class Cost>
OptimalControlProblem problem(Cost cost, Bounds input = unbounded()) {
  Phase<1, 1> phase{"only", Integrator1{}, exactly(1.0)};
  phase.minimise("cost", cost).bound_input(0, input);
  OptimalControlProblem ocp("curved");
  ocp.start_at({0}).then(phase);
  return ocp;
}

std::vector<std::unique_ptr<Solver>> solvers() {
  std::vector<std::unique_ptr<Solver>> result;
  result.push_back(make_ipopt());
  result.push_back(make_sqp());
  result.push_back(make_sqp({.qp = riccati_qp()}));
  return result;
}

Solution solved(const OptimalControlProblem& ocp, Solver& solver) {
  MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  return solve(shooting, solver);
}

TEST(SecondOrder, AMaximumIsNoOptimum) {
  const OptimalControlProblem ocp =
      problem([](auto, auto, auto u) { return -u[0] * u[0] - 0.1 * u[0] * u[0] * u[0] * u[0]; });
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    EXPECT_FALSE(s.ok()) << solver->name() << ": " << s.message;
  }
}

TEST(SecondOrder, AMaximumOfAQuadraticCostIsNoOptimum) {
  const OptimalControlProblem ocp = problem([](auto, auto, auto u) { return -u[0] * u[0]; });
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    EXPECT_FALSE(s.ok()) << solver->name() << ": " << s.message;
    EXPECT_NE(s.message.find("input 0"), std::string::npos) << solver->name() << ": " << s.message;
  }
}

TEST(SecondOrder, ASaddleHasAHint) {
  const OptimalControlProblem ocp =
      problem([](auto, auto x, auto u) { return x[0] * x[0] - 2.0 * u[0] * u[0]; });
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    EXPECT_FALSE(s.ok()) << solver->name() << ": " << s.message;
    const bool says = s.message.find("not convex") != std::string::npos ||
                      s.message.find("saddle") != std::string::npos ||
                      s.status == SolveStatus::unbounded;
    EXPECT_TRUE(says) << solver->name() << ": " << s.message;
  }
}

// At its bounds a cost that curves downward has a minimum all the same.
TEST(SecondOrder, ACornerIsAnOptimum) {
  const OptimalControlProblem ocp =
      problem([](auto, auto x,
                 auto u) { return x[0] - 0.1 * u[0] * u[0] + 0.01 * u[0] * u[0] * u[0] * u[0]; },
              between(-1.0, 1.0));
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    EXPECT_TRUE(s.ok()) << solver->name() << ": " << s.message;
    EXPECT_TRUE(s.curvature_checked);
  }
}

// Singular arcs and inputs that cost nothing: semidefinite, and no saddle.
TEST(SecondOrder, FlatIsNoSaddle) {
  for (const auto& solver : solvers()) {
    const Solution singular = solved(
        problem([](auto, auto x, auto) { return (x[0] - 0.2) * (x[0] - 0.2); }, between(-1, 1)),
        *solver);
    EXPECT_TRUE(singular.ok()) << solver->name() << ": " << singular.message;
    const Solution quartic =
        solved(problem([](auto, auto, auto u) { return u[0] * u[0] * u[0] * u[0]; }), *solver);
    EXPECT_TRUE(quartic.ok()) << solver->name() << ": " << quartic.message;
  }
}

TEST(SecondOrder, TheDirectionIsWhatItSays) {
  MultipleShooting shooting(problem([](auto, auto, auto u) { return -u[0] * u[0]; }),
                            {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  NlpPoint point = shooting.initial_guess();
  point.w.setZero();
  point.lambda = VectorXd::Zero(shooting.nlp().rows());
  point.z = VectorXd::Zero(shooting.nlp().variables());
  const SecondOrderCheck check = check_second_order(shooting.nlp(), point);
  ASSERT_EQ(check.verdict, SecondOrderCheck::Verdict::descent);
  double here = 0.0, there = 0.0;
  shooting.nlp().objective(point.w.data(), here);
  const VectorXd moved = point.w + 0.1 * check.direction;
  shooting.nlp().objective(moved.data(), there);
  EXPECT_LT(there, here - 1e-4);
  VectorXd rows(shooting.nlp().rows());
  shooting.nlp().constraints(moved.data(), rows.data());
  EXPECT_LT(rows.cwiseAbs().maxCoeff(), 1e-5);
}

}  // namespace
}  // namespace saltus
