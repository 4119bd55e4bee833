// Every problem with a known answer reaches it from its own initial guess.
#include "problems/library/catalogue.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "problems/library/run_case.hpp"
#include "saltus/core/error.hpp"
#include "saltus/solver/native_solver.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/print_cases.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

class Reference : public testing::TestWithParam<ReferenceCase> {};

// Checks cost, switching times, KKT residual, replay with a tighter integrator, and other known
// values.
TEST_P(Reference, MatchesAllKnownValuesFromItsGuess) {
  const ReferenceCase& c = GetParam();
  EXPECT_LE(c.tolerance, c.digits >= 8 ? 1e-6 : 1e-4);  // required of every case
  Solution solution = solve_case(c);
  if (solution.status == SolveStatus::coarse_grid)  // B01, as `saltus run` does
    solution = solve_case_refined(c, SolverChoice::ipopt, RefinementOptions{}.rounds, {}).solution;
  EXPECT_EQ(solution.status, SolveStatus::optimal) << solution.message;
  const CaseOutcome outcome = check_case(c, solution);
  EXPECT_EQ(outcome.verdict, Verdict::met);
  for (const std::string& reason : outcome.reasons()) ADD_FAILURE() << reason;
  EXPECT_TRUE(c.switching_times.empty() ||
              solution.durations.size() == c.switching_times.size() + 1);
}

TEST_P(Reference, DerivativesOfTheProgramAreExact) {
  const ReferenceCase& c = GetParam();
  ShootingOptions few = c.options;
  few.intervals_per_phase = std::min(few.intervals_per_phase, c.derivatives.intervals);
  for (int& n : few.intervals) n = std::min(n, c.derivatives.intervals);
  few.meshes.clear();
  if (c.derivatives.integrator) few.integrator = c.derivatives.integrator;
  MultipleShooting shooting(c.problem(), few);
  const NlpPoint point = testing_support::perturbed(shooting.nlp(), shooting.initial_guess().w, 7,
                                                    c.derivatives.radius);
  const auto errors = testing_support::derivative_errors(shooting.nlp(), point, Curvature::exact,
                                                         c.derivatives.step);
  EXPECT_LT(errors.gradient, c.derivatives.tolerance);
  EXPECT_LT(errors.jacobian, c.derivatives.tolerance);
  EXPECT_LT(errors.hessian, c.derivatives.tolerance);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, Reference, testing::ValuesIn(reference_cases()),
                         [](const auto& instance) { return instance.param.id; });

// The state that a solver keeps from one solve must not change the result of another.
TEST(ReusedSolver, IsBitIdentical) {
  for (const QpMethod& method : {riccati_qp(), sparse_qp()})
    for (const ReferenceCase& c : reference_cases()) {
      if (c.id != "A12b" && c.id != "B01" && c.id != "B02c") continue;
      MultipleShooting shooting(c.problem(), c.options);
      const auto solver = make_native_solver({.tolerance = 1e-8, .qp = method});
      const NlpPoint guess = shooting.initial_guess();
      const NlpResult first = solver->solve(shooting.nlp(), guess, false);
      const NlpResult second = solver->solve(shooting.nlp(), guess, false);
      EXPECT_EQ(first.status, second.status) << c.id;
      EXPECT_EQ(first.iterations, second.iterations) << c.id;
      EXPECT_EQ(first.point.w, second.point.w) << c.id;
    }
}

class Simulated : public testing::TestWithParam<SimulationCase> {};

TEST_P(Simulated, MatchesAllKnownValues) {
  const CaseOutcome outcome = run_case(GetParam());
  EXPECT_EQ(outcome.verdict, Verdict::met);
  for (const std::string& reason : outcome.reasons()) ADD_FAILURE() << reason;
  EXPECT_FALSE(GetParam().exercises.empty() || GetParam().source.empty());
}

INSTANTIATE_TEST_SUITE_P(Catalogue, Simulated, testing::ValuesIn(simulation_cases()),
                         [](const auto& instance) { return instance.param.id; });

TEST(Catalogue, IdsAndNamesAreUnique) {
  for (const ReferenceCase& c : reference_cases()) {
    EXPECT_EQ(&reference_case(c.id), &c);
    EXPECT_EQ(&reference_case(c.name), &c);
    EXPECT_FALSE(c.exercises.empty() || c.source.empty() || c.digits == 0);
  }
}

TEST(Catalogue, UnknownNameSuggestsTheNearest) {
  expect_error<InputError>([] { reference_case("pendulum_on_card"); },
                           {"did you mean 'pendulum_on_cart'"});
}

TEST(BrysonDenham, StaysBelowTheCeilingBetweenNodes) {
  const Solution solution =
      solve_case_refined(reference_case("B01"), SolverChoice::ipopt, RefinementOptions{}.rounds, {})
          .solution;
  const Trajectory& trajectory = solution.trajectory;
  for (int i = 0; i <= 1000; ++i) EXPECT_LE(trajectory.state(i / 1000.0)[0], 1.0 / 9.0 + 1e-8) << i;
  EXPECT_NEAR(trajectory.state(0.5)[0], 1.0 / 9.0, 1e-7);  // slides along the ceiling
  // u(t) = -(2 / (3 l)) (1 - t / (3 l)) on the climb.
  EXPECT_NEAR(trajectory.input(0.0)[0], -6.0, 1e-4);
  EXPECT_NEAR(trajectory.input(1.0 / 6.0)[0], -3.0, 1e-4);
}

TEST(InteriorPoint, FollowsTheClosedForm) {
  const Solution solution = solve_case(reference_case("B22"));
  const auto exact = [](double a, double b, double T, double t) {
    return (a * std::sinh(T - t) + b * std::sinh(t)) / std::sinh(T);
  };
  for (int i = 0; i <= 100; ++i) {
    const double t = i / 100.0;
    const double x = t < 0.75 ? exact(1.0, 0.9, 0.75, t) : exact(0.9, 0.75, 0.25, t - 0.75);
    EXPECT_NEAR(solution.trajectory.state(t)[0], x, 1e-7) << t;  // h^3 of the linear pieces
  }
  // The input jumps at the point, from the slope of the first trajectory to that of the second.
  EXPECT_NEAR(solution.trajectory.input(0.75 - 1e-9)[0],
              (0.9 * std::cosh(0.75) - 1.0) / std::sinh(0.75), 1e-4);
  EXPECT_NEAR(solution.trajectory.input(0.75)[0], (0.75 - 0.9 * std::cosh(0.25)) / std::sinh(0.25),
              1e-4);
}

TEST(PhaseTransition, MatchesTheIndependentSolution) {
  const Solution solution = solve_case(reference_case("C02"));
  const Trajectory& trajectory = solution.trajectory;
  EXPECT_NEAR(trajectory.input(0.0)[0], -50.0, 1e-5);
  const VectorXd before = trajectory.state_before(0.4), after = trajectory.state(0.4);
  ASSERT_EQ(before.size(), 2);
  ASSERT_EQ(after.size(), 1);
  EXPECT_NEAR(before[0], 0.3792765820, 1e-8);
  EXPECT_NEAR(before[1], -3.0405445445, 1e-7);
  EXPECT_NEAR(after[0], before[0], 1e-12);
  EXPECT_NEAR(trajectory.final_state()[0], 0.0035807013, 1e-8);
}

TEST(PendulumOnCart, SwingsUpWithFullForceAtFirst) {
  const Solution solution = solve_case(reference_case("C03"));
  EXPECT_NEAR(solution.trajectory.input(0.00)[0], 80.0, 1e-6);
  EXPECT_NEAR(solution.trajectory.input(0.05)[0], 80.0, 1e-6);
  const Vec<double, 4> end{-0.0072655, 0.0057768, -0.1574767, 0.1988130};
  // Seven decimals are known.
  EXPECT_LT((solution.trajectory.final_state() - end).cwiseAbs().maxCoeff(), 1e-7);
}

}  // namespace
}  // namespace saltus
