// The program of the design page compiles, solves, and gives the documented results.
#include <gtest/gtest.h>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"
#include "tests/problems/two_gears.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus::two_gears {
namespace {

// The program of the design page, except for solve(), which also interprets the result.
TEST(DesignProgram, SolvesAsWritten) {
  MultipleShooting shooting{problem(),
                            {.intervals_per_phase = 30, .integrator = cvodes({.tolerance = 1e-9})}};
  const auto solver = make_ipopt({.tolerance = 1e-8});
  const Solution solution = solve(shooting, *solver);
  ASSERT_TRUE(solution.ok()) << solution.message;
  EXPECT_EQ(solution.method,
            "CVODES BDF, tolerance 1e-09, costs integrated, limited-memory BFGS Hessian");
}

class TwoGears : public testing::Test {
 protected:
  MultipleShooting shooting{problem(),
                            {.intervals_per_phase = 30, .integrator = runge_kutta4({.steps = 4})}};
  Solution solution = solve(shooting, *make_ipopt({.tolerance = 1e-9}));
};

TEST_F(TwoGears, SatisfiesItsConstraints) {
  ASSERT_EQ(solution.status, SolveStatus::optimal) << solution.message;
  EXPECT_LT(solution.kkt.scaled(), 1e-7);
  const Trajectory& trajectory = solution.trajectory;
  const double shift = solution.durations[0];
  EXPECT_NEAR(trajectory.end_time(), solution.durations[0] + solution.durations[1], 1e-12);
  EXPECT_LE(trajectory.state_before(shift)[1], 12.0 + 1e-8);
  EXPECT_NEAR(trajectory.state(shift)[1], 0.97 * trajectory.state_before(shift)[1], 1e-9);
  for (int i = 0; i <= 30; ++i) EXPECT_LE(trajectory.state(shift + 0.01 * i)[1], 14.0 + 1e-6) << i;
  EXPECT_NEAR(trajectory.final_state()[0], 100.0, 1e-8);
  EXPECT_NEAR(trajectory.final_state()[1], 0.0, 1e-8);
}

TEST_F(TwoGears, HasANodeAtTheWindowEndForAnyDuration) {
  bool found = false;
  for (const Trajectory::Piece& piece : solution.trajectory.pieces())
    found =
        found || (piece.phase == 1 && std::abs(piece.start - solution.durations[0] - 0.3) < 1e-9);
  EXPECT_TRUE(found);
}

TEST_F(TwoGears, CostIsTheSumOfItsTerms) {
  double sum = 0.0;
  for (const Solution::CostContribution& share : solution.costs) {
    sum += share.value;
    if (share.term == "time") {
      EXPECT_NEAR(share.value, solution.trajectory.end_time(), 1e-9);
    }
  }
  EXPECT_NEAR(sum, solution.cost, 1e-9 * solution.cost);
}

TEST_F(TwoGears, PlanHoldsUnderATighterIntegrator) {
  // Four steps of order four per interval are accurate to 1e-10. The replay includes the clutch.
  const ReplayReport report = replay(problem(), solution.trajectory,
                                     cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14}));
  ASSERT_TRUE(report.completed);
  EXPECT_LT(report.from_nodes, 1e-8);
  EXPECT_LT(report.from_start, 1e-8);
}

TEST_F(TwoGears, DerivativesAreExactWithDurationsJumpAndWindow) {
  MultipleShooting small{problem(), {.intervals_per_phase = 4, .integrator = runge_kutta4()}};
  const NlpPoint point = testing_support::perturbed(small.nlp(), small.initial_guess().w, 3);
  const auto errors = testing_support::derivative_errors(small.nlp(), point);
  EXPECT_LT(errors.gradient, 1e-7);  // differences are accurate to 1e-9 of numbers up to 100
  EXPECT_LT(errors.jacobian, 1e-7);
  EXPECT_LT(errors.hessian, 1e-7);
}

}  // namespace
}  // namespace saltus::two_gears
