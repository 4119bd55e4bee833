// Messages of optimal control problems that have no solution: they name phase, term, time and
// amount.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

Solution attempt(const OptimalControlProblem& ocp, const IpoptOptions& options = {}) {
  MultipleShooting shooting(ocp, ten);
  return solve(shooting, *make_ipopt(options));
}

void expect_in(const std::string& fragment, const std::string& text) {
  EXPECT_NE(text.find(fragment), std::string::npos) << "'" << fragment << "' is not in: " << text;
}

OptimalControlProblem too_far(Vec<double, 2> nominal_state) {
  Phase<2, 1> run{"run", Cart{}, exactly(2.0)};
  run.bound_input(0, between(-1.0, 1.0))
      .track("effort", input, Vec<double, 1>{1.0})
      .reach("goal", position, exactly(5.0))  // at most 2 can be reached
      .nominal(nominal_state, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("too far");
  return ocp.start_at({0, 0}).then(run);
}

TEST(Infeasible, NamesPhaseTermTimeAndAmount) {
  // The message does not depend on the scaling of the states or on the distribution of the
  // violation.
  for (const Vec<double, 2>& nominal :
       {Vec<double, 2>{1.0, 1.0}, Vec<double, 2>{100.0, 100.0}, Vec<double, 2>{0.01, 0.01}}) {
    const Solution s = attempt(too_far(nominal));
    EXPECT_EQ(s.status, SolveStatus::infeasible);
    EXPECT_FALSE(s.ok());
    expect_in("phase 'run', term 'goal', row 0 at t = 2 s violates its bounds by 3", s.message);
  }
}

TEST(Infeasible, NamesTheTimeAtTheDurationReached) {
  Phase<2, 1> run{"run", Cart{}, between(0.5, 2.0)};
  run.bound_input(0, between(-1.0, 1.0))
      .track("effort", input, Vec<double, 1>{1.0})
      .reach("goal", position, exactly(5.0))
      .guess_duration(1.0);
  OptimalControlProblem ocp("too far");
  const Solution s = attempt(ocp.start_at({0, 0}).then(run));
  EXPECT_EQ(s.status, SolveStatus::infeasible);
  expect_in("phase 'run', term 'goal', row 0 at t = 2 s violates its bounds by 3", s.message);
}

TEST(Infeasible, NamesBoundsOfStatesInTheirUnits) {
  Phase<2, 1> run{"run", Cart{}, exactly(2.0)};
  run.bound_input(0, between(-1.0, 1.0))
      .track("effort", input, Vec<double, 1>{1.0})
      .keep("fence", position, at_most(0.0))
      .bound_state(1, at_least(0.5), Window{.from = 1.0})
      .nominal(Vec<double, 2>{10.0, 10.0}, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("contradiction");
  const Solution s = attempt(ocp.start_at({0, 0}).then(run));
  EXPECT_EQ(s.status, SolveStatus::infeasible);
  expect_in("phase 'run', ", s.message);
  expect_in("violates its bounds by ", s.message);
}

// min int x^2 - 2 u^2 with x' = u, x(0) = 0. As a linear-quadratic program it is not convex.
OptimalControlProblem not_convex(bool bounded, double guess) {
  const auto rate = [](const auto&, const auto&, const auto& u) { return u; };
  Phase<1, 1> phase{"phase", rate, exactly(1.0)};
  phase
      .minimise("cost", [](const auto&, const auto& x,
                           const auto& u) { return x[0] * x[0] - 2.0 * u[0] * u[0]; })
      .guess_input(Guess::constant(Vec<double, 1>{guess}));
  if (bounded) phase.bound_input(0, between(-1.0, 1.0));
  OptimalControlProblem ocp("not convex");
  ocp.start_at({0.0}).then(phase);
  return ocp;
}

TEST(NotConvex, LinearQuadraticProgramsEndInAMinimumOrAMessage) {
  const ShootingOptions options{.intervals_per_phase = 20, .integrator = runge_kutta4()};
  for (const SolverChoice choice :
       {SolverChoice::ipopt, SolverChoice::sparse, SolverChoice::riccati}) {
    const auto solution = [&](bool bounded, double guess) {
      MultipleShooting shooting(not_convex(bounded, guess), options);
      return solve(shooting, *make_solver(choice));
    };
    const Solution minimum = solution(true, 0.1);
    EXPECT_EQ(minimum.status, SolveStatus::optimal) << name_of(choice) << minimum.message;
    EXPECT_LT(minimum.cost, -1.8);  // -2 without the integral of x^2: inputs are at their bounds
    EXPECT_EQ(solution(true, 0.0).status, SolveStatus::no_minimum) << name_of(choice);
    const Solution endless = solution(false, 0.1);
    EXPECT_TRUE(endless.status == SolveStatus::unbounded ||
                endless.status == SolveStatus::no_minimum)
        << name_of(choice) << endless.message;
  }
}

TEST(IterationLimit, ReportsTheProgress) {
  const Solution s = attempt(too_far({1.0, 1.0}), {.max_iterations = 1});
  EXPECT_EQ(s.status, SolveStatus::iteration_limit);
  expect_in("the iteration limit was reached; phase 'run', term 'goal'", s.message);
  EXPECT_FALSE(s.trajectory.empty());
}

TEST(TimeLimit, EndsTheSolve) {
  const Solution s = attempt(too_far({1.0, 1.0}), {.time_limit = 1e-6});
  EXPECT_EQ(s.status, SolveStatus::time_limit);
}

TEST(EvaluationFailed, IsReportedOutsideADomain) {
  Phase<1, 1> phase{"root",
                    [](const auto&, const auto& x, const auto& u) { return sqrt(x[0]) + u[0]; },
                    exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("domain");
  const Solution s = attempt(ocp.start_at({-1}).then(phase));
  EXPECT_EQ(s.status, SolveStatus::evaluation_failed);
  EXPECT_FALSE(s.message.empty());
}

TEST(WarmStart, NeedsFewerIterationsForAnOptimalControlProblem) {
  Phase<2, 1> run{"run", Cart{}, exactly(2.0)};
  run.bound_input(0, between(-1.0, 1.0))
      .track("effort", input, Vec<double, 1>{1.0})
      .keep(
          "speed", [](const auto&, const auto& x) { return x[1]; }, at_most(0.6))
      .reach("goal", position, exactly(0.9));
  OptimalControlProblem ocp("warm");
  MultipleShooting shooting(ocp.start_at({0, 0}).then(run), ten);
  const auto solver = make_ipopt();
  const Solution cold = solve(shooting, *solver);
  ASSERT_TRUE(cold.ok()) << cold.message;
  shooting.start_at(0.0, Vec<double, 2>{0.01, 0.0});
  const Solution again = solve(shooting, *solver);
  const Solution warm = solve(shooting, *solver, cold.point);
  ASSERT_TRUE(again.ok() && warm.ok()) << again.message << warm.message;
  EXPECT_LT(warm.iterations, again.iterations);
  EXPECT_NEAR(warm.cost, again.cost, 1e-7 * again.cost);
}

TEST(SolverLimits, OutOfRangeIsRejected) {
  const double nan = std::nan("");
  for (const double tolerance : {0.0, -1.0, nan, infinity}) {
    EXPECT_THROW(make_ipopt({.tolerance = tolerance}), DefinitionError) << tolerance;
    EXPECT_THROW(make_native_solver({.tolerance = tolerance}), DefinitionError) << tolerance;
  }
  for (const double time_limit : {-1.0, nan, infinity}) {
    EXPECT_THROW(make_ipopt({.time_limit = time_limit}), DefinitionError) << time_limit;
    EXPECT_THROW(make_native_solver({.time_limit = time_limit}), DefinitionError) << time_limit;
  }
  EXPECT_THROW(make_ipopt({.max_iterations = -1}), DefinitionError);
  EXPECT_THROW(make_native_solver({.max_iterations = -1}), DefinitionError);
}

}  // namespace
}  // namespace saltus
