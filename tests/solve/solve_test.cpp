// One call from a problem to its solution. The defaults give an optimum, and each default can be
// replaced.
#include <saltus/saltus.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "saltus/solver/ipopt.hpp"

namespace saltus {
namespace {

// 100 m at no more than 1 m/s^2 from rest to rest: full throttle, then full brake, 20 s.
OptimalControlProblem race() {
  const auto dynamics = [](const auto&, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>{x[1], u[0]};
  };
  Phase<2, 1> drive{"drive", dynamics, between(5.0, 40.0)};
  drive.bound_input(0, between(-1.0, 1.0))
      .reach(
          "finish", [](const auto&, const auto& x) { return x[0]; }, exactly(100.0))
      .reach(
          "at rest", [](const auto&, const auto& x) { return x[1]; }, exactly(0.0))
      .minimise_at_end("time", [](const auto& t, const auto&) { return t; });
  OptimalControlProblem ocp("race");
  ocp.start_at({0, 0}).then(drive);
  return ocp;
}

TEST(Solve, DefaultsFindTheOptimum) {
  const Solution s = solve(race());
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.cost, 20.0, 1e-6);
  EXPECT_EQ(s.trajectory.pieces().size(), 30u);
  EXPECT_NE(s.method.find("Runge-Kutta"), std::string::npos) << s.method;
}

TEST(Solve, GridIntegratorSolverAndGuessAreReplaceable) {
  const std::shared_ptr<Solver> ipopt = make_ipopt({.tolerance = 1e-9});
  const Solution s =
      solve(race(), {.intervals_per_phase = 12, .integrator = zero_order_hold(), .solver = ipopt});
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.cost, 20.0, 1e-6);
  EXPECT_EQ(s.trajectory.pieces().size(), 12u);
  EXPECT_NE(s.method.find("zero-order hold"), std::string::npos) << s.method;

  const Solution finer = solve(race(), {.intervals = {24}, .solver = ipopt, .guess = s.trajectory});
  ASSERT_TRUE(finer.ok()) << finer.message;
  EXPECT_NEAR(finer.cost, 20.0, 1e-6);
  EXPECT_EQ(finer.trajectory.pieces().size(), 24u);
  EXPECT_THROW(solve(race(), {.intervals = {24, 24}}), DefinitionError);
}

// min int x^2 + u^2 with x' = x + u from 1 in one second: sinh / (sqrt(2) cosh - sinh) at sqrt(2)
// in closed form. The numbers of the README are those of this problem, and the default is the
// integral.
TEST(Solve, CostRuleErrorsMatchTheReadme) {
  const auto dynamics = [](const auto&, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>{x[0] + u[0]};
  };
  Phase<1, 1> phase{"phase", dynamics, exactly(1.0)};
  const auto both = [](const auto&, const auto& x, const auto& u) {
    return x[0] * x[0] + u[0] * u[0];
  };
  phase.minimise("both", both);
  OptimalControlProblem ocp("regulator");
  ocp.start_at({1.0}).then(phase);
  const double r = std::sqrt(2.0);
  constexpr double printed = 6e-5;
  EXPECT_NEAR(std::sinh(r) / (r * std::cosh(r) - std::sinh(r)), 1.68950, printed);
  const int intervals[] = {10, 30, 100};
  const double nodes[] = {1.6601, 1.6804, 1.6868}, integrated[] = {1.69203, 1.68978, 1.68952};
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(solve(ocp, {.intervals_per_phase = intervals[i]}).cost, integrated[i], printed);
    OptimalControlProblem summed = ocp;
    summed.costs(CostRule::nodes);
    EXPECT_NEAR(solve(summed, {.intervals_per_phase = intervals[i]}).cost, nodes[i], printed);
  }
}

// The observer of one solve is not used in the next, even after an exception.
TEST(Solve, ThrowingObserverIsNotCalledAgain) {
  const std::shared_ptr<Solver> solver = make_native_solver();
  int heard = 0;
  SolveOptions watched{.solver = solver};
  watched.observer.report = [&](const SolveObserver::Iteration&) {
    ++heard;
    throw std::runtime_error("enough");
  };
  EXPECT_THROW(solve(race(), watched), std::runtime_error);
  EXPECT_EQ(heard, 1);
  EXPECT_TRUE(solve(race(), {.solver = solver}).ok());
  EXPECT_EQ(heard, 1);
  EXPECT_FALSE(solver->observer().report);
}

TEST(Solve, InvalidLimitIsAStatus) {
  const Solution s = solve(race(), {.solver = make_native_solver({.max_iterations = 1})});
  EXPECT_FALSE(s.ok());
  EXPECT_EQ(s.status, SolveStatus::iteration_limit) << s.message;
}

}  // namespace
}  // namespace saltus
