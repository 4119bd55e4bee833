// Violations of path constraints between the nodes: reports, and refinement that removes them.
#include "saltus/transcription/between_nodes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

// Bryson and Denham's block as one phase: from the ground back to the ground in one second under a
// ceiling at l, with the least effort 1/2 int u^2. For l <= 1/6 it slides along the ceiling and
// J = 4 / (9 l); for 1/6 <= l <= 1/4 it touches it at t = 1/2 and J = 2 + 6 (1 - 4 l)^2.
Phase<2, 1> block() {
  Phase<2, 1> phase{"block", Cart{}, exactly(1.0)};
  phase.inputs(InputParametrisation::piecewise_linear_continuous)
      .minimise("effort", effort)
      .reach("ground", height, exactly(0.0))
      .reach("landing speed", speed, exactly(-1.0));
  return phase;
}
OptimalControlProblem bryson_denham(const Phase<2, 1>& phase) {
  OptimalControlProblem ocp("Bryson-Denham");
  ocp.start_at({0, 1}).then(phase).costs(CostRule::integrated);
  return ocp;
}
std::unique_ptr<Solver> ipopt() { return make_ipopt({.tolerance = 1e-11}); }
ShootingOptions intervals(int n) {
  return {.intervals_per_phase = n, .integrator = runge_kutta4()};
}

TEST(BetweenNodes, MeasuresTheViolation) {
  // With five intervals, the top is in the middle of the third one.
  Phase<2, 1> phase = block();
  phase.keep("ceiling", height, at_most(0.2));
  MultipleShooting shooting(bryson_denham(phase), intervals(5));
  const Solution s = solve(shooting, *ipopt());
  EXPECT_EQ(s.status, SolveStatus::coarse_grid) << s.message;
  EXPECT_LT(s.cost, 2.24 - 1e-4);
  ASSERT_TRUE(s.verification.has_value());
  const Verification::Miss& miss = s.verification->between_nodes;
  EXPECT_EQ(miss.phase, "block");
  EXPECT_EQ(miss.term, "ceiling");
  EXPECT_NEAR(miss.time, 0.5, 1e-3);
  const double top = s.trajectory.state(0.5)[0] - 0.2;
  EXPECT_GT(top, 1e-3);
  EXPECT_NEAR(miss.amount, top, 0.01 * top);
}

TEST(BetweenNodes, BoundsOfStatesCountAndSoftTermsDoNot) {
  Phase<2, 1> phase = block();
  phase.bound_state(0, at_most(0.2))
      .keep("soft", height, at_most(0.01), {}, soft("soft", 1e-3))
      .allow("bounds of state 0", 0.1);
  MultipleShooting shooting(bryson_denham(phase), intervals(5));
  const Solution s = solve(shooting, *ipopt());
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_EQ(s.verification->between_nodes.term, "bounds of state 0");
  EXPECT_LT(s.verification->between_nodes.amount, 0.1);
}

TEST(BetweenNodes, ChecksOpenWindowsOnly) {
  Phase<2, 1> phase = block();
  phase.keep("ceiling", height, at_most(0.2), Window{.to = 0.35});
  phase.keep("floor", height, at_least(-1.0));
  MultipleShooting shooting(bryson_denham(phase), intervals(5));
  const Solution s = solve(shooting, *ipopt());
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_GT(s.trajectory.state(0.5)[0], 0.2);  // beyond the window it rises
  EXPECT_LE(s.verification->between_nodes.time, 0.35);
  EXPECT_LT(s.verification->between_nodes.amount, 1e-8);
}

// A cart that starts above its speed limit is within the limit at the first node. A given start has
// no rows, so the return to the limit is not a violation.
OptimalControlProblem hurried_cart(double speed_at_start) {
  Phase<2, 1> phase{"go", Cart{}, exactly(2.0)};
  phase.bound_input(0, between(-5.0, 5.0))
      .keep("speed", speed, between(-1.0, 1.0))
      .reach("there", [](const auto&, const auto& x) { return x; }, {exactly(1.0), exactly(0.0)})
      .minimise("effort", effort);
  OptimalControlProblem ocp("hurried cart");
  ocp.start_at({0.0, speed_at_start}).then(phase);
  return ocp;
}

TEST(BetweenNodes, ReturnFromAGivenStartIsNoViolation) {
  for (const double v : {1.01, 1.1, 1.3}) {
    MultipleShooting shooting(hurried_cart(v), intervals(20));
    const Solution s = solve(shooting, *ipopt());
    EXPECT_TRUE(s.ok()) << s.message;
    EXPECT_LT(s.verification->between_nodes.amount, 1e-8);
    const RefinedSolution r = solve_refined(hurried_cart(v), intervals(20), *ipopt());
    EXPECT_TRUE(r.reached) << r.message;
    EXPECT_EQ(r.intervals, std::vector<int>{20});
  }
}

// Starts 0.02 m beyond the wall and moves outward at 0.9 m/s. It moves further out within the first
// interval.
TEST(BetweenNodes, MovingFurtherOutThanTheGivenStartIsAViolation) {
  Phase<2, 1> phase{"go", Cart{}, exactly(2.0)};
  phase.bound_state(0, at_most(0.98))
      .reach("there", height, exactly(0.5))
      .minimise("effort", effort);
  OptimalControlProblem ocp("beyond the wall");
  ocp.start_at({1.0, 0.9}).then(phase);
  MultipleShooting outwards(ocp, intervals(5));
  const Solution s = solve(outwards, *ipopt());
  EXPECT_EQ(s.status, SolveStatus::coarse_grid) << s.message;
  double top = 0.0;
  for (int i = 0; i <= 400; ++i) top = std::max(top, s.trajectory.state(1e-3 * i)[0]);
  EXPECT_NEAR(s.verification->between_nodes.amount, top - 1.0, 1e-3);
  EXPECT_LT(s.verification->between_nodes.time, 0.4);
}

// A phase of zero length has no violation between its nodes. States of the next phase do not count.
TEST(BetweenNodes, VanishedPhaseHasNoViolation) {
  Phase<2, 1> out{"out", Cart{}, between(0.0, 1.0)}, back{"back", Cart{}, exactly(1.0)};
  out.keep("forward", speed, at_least(0.0)).minimise("effort", effort);
  back.minimise("effort", effort);
  OptimalControlProblem ocp("turn");
  ocp.start_at({0, 1}).then(out).then(back, jump<2>("turn", [](const auto&, const auto& x) {
                                        return std::decay_t<decltype(x)>{x[0], -x[1]};
                                      }));
  MultipleShooting shooting(ocp, intervals(4));
  shooting.set_remaining(exactly(0.0), {});
  const Solution s = solve(shooting, *ipopt());
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_EQ(s.verification->between_nodes.amount, 0.0);

  Phase<2, 1> last{"last", Cart{}, between(0.0, 1.0)};
  last.inputs(InputParametrisation::piecewise_linear).minimise("effort", effort);
  OptimalControlProblem stays("stays");
  stays.start_at({0, 1}).then(last);
  MultipleShooting none(stays, intervals(4));
  none.set_remaining(exactly(0.0), {});
  const Solution nothing = solve(none, *ipopt());
  ASSERT_TRUE(nothing.ok()) << nothing.message;
  EXPECT_TRUE(nothing.trajectory.input(nothing.trajectory.end_time()).allFinite());
}

TEST(BetweenNodes, IsNotMeasuredInControlLoops) {
  MultipleShooting shooting(bryson_denham(block()), intervals(5));
  const NlpResult result = ipopt()->solve(shooting.nlp(), shooting.initial_guess(), false);
  EXPECT_FALSE(shooting.interpret(result).verification.has_value());
}

TEST(Refinement, ReachesTheOptimumFromBelow) {
  Phase<2, 1> phase = block();
  phase.keep("ceiling", height, at_most(1.0 / 9.0));
  double before = 0.0, bulge = infinity;
  for (const int rounds : {1, 2, 3}) {
    const RefinedSolution r = solve_refined(bryson_denham(phase), intervals(10), *ipopt(),
                                            {.tolerance = 1e-8, .rounds = rounds});
    ASSERT_EQ(r.violations.size(), static_cast<std::size_t>(rounds)) << r.message;
    EXPECT_GT(r.solution.cost, before);
    EXPECT_LT(r.solution.cost, 4.0 + 1e-9);  // the solver's tolerance
    EXPECT_LT(r.violations.back(), bulge);
    before = r.solution.cost;
    bulge = r.violations.back();
  }
}

// A window that begins at the start divides nothing. A graded mesh is refined where necessary.
TEST(Refinement, HandlesAFreePhaseWithGradedMeshAndWindow) {
  Phase<2, 1> phase{"block", Cart{}, between(0.9, 1.1)};
  phase.inputs(InputParametrisation::piecewise_linear_continuous)
      .minimise("effort", effort)
      .reach("ground", height, exactly(0.0))
      .reach("landing speed", speed, exactly(-1.0))
      .keep("ceiling", height, at_most(0.2), Window{.from = 0.0})
      .guess_duration(1.0);
  ShootingOptions options = intervals(6);
  options.meshes = {graded_mesh(6, 3.0)};
  const RefinedSolution r = solve_refined(bryson_denham(phase), options, *ipopt());
  EXPECT_TRUE(r.reached) << r.message;
  EXPECT_GT(r.intervals[0], 6);
}

TEST(Refinement, ReportsTheResult) {
  Phase<2, 1> phase = block();
  phase.keep("ceiling", height, at_most(1.0 / 9.0));
  const RefinedSolution r = solve_refined(bryson_denham(phase), intervals(10), *ipopt());
  EXPECT_TRUE(r.reached) << r.message;
  EXPECT_EQ(r.message.find("integration"), std::string::npos) << r.message;  // it is exact
  EXPECT_LE(r.violations.back(), 1e-6);
  EXPECT_LE(r.solution.verification->between_nodes.amount, 1e-6);
  EXPECT_NEAR(r.solution.cost, 4.0, 1e-6);
  // The count includes all rounds.
  EXPECT_GT(r.iterations, r.solution.iterations);
  EXPECT_GT(r.seconds, r.solution.seconds);
  const RefinedSolution limited = solve_refined(bryson_denham(phase), intervals(10), *ipopt(),
                                                {.tolerance = 1e-11, .most_intervals = 25});
  EXPECT_FALSE(limited.reached);
  EXPECT_LE(limited.intervals.front(), 25);
  EXPECT_NE(limited.message.find("the limit is 25"), std::string::npos) << limited.message;
  EXPECT_NE(limited.message.find("'ceiling' of phase 'block'"), std::string::npos)
      << limited.message;
}

// A violation of 27 mm is within the refinement tolerance of 50 mm but exceeds the tolerance of the
// term. The plan is infeasible and is refined until it is feasible.
TEST(Refinement, IsNotDoneWithoutAPlan) {
  Phase<2, 1> phase{"go", Cart{}, exactly(1.0)};
  phase.keep("wall", height, at_most(1.02))
      .reach("there", [](const auto&, const auto& x) { return x; }, {exactly(1.0), exactly(-1.0)})
      .minimise("effort", effort);
  OptimalControlProblem ocp("wall");
  ocp.start_at({0, 0}).then(phase);
  const RefinedSolution none =
      solve_refined(ocp, intervals(6), *ipopt(), {.tolerance = 0.05, .rounds = 1});
  EXPECT_EQ(none.solution.status, SolveStatus::coarse_grid);
  EXPECT_LT(none.violations.back(), 0.05);
  EXPECT_FALSE(none.reached);
  const RefinedSolution r = solve_refined(ocp, intervals(6), *ipopt(), {.tolerance = 0.05});
  EXPECT_TRUE(r.reached) << r.message;
  EXPECT_TRUE(r.solution.ok()) << r.solution.message;
  // The message contains the present value and the limit.
  const RefinedSolution limited =
      solve_refined(ocp, intervals(6), *ipopt(), {.tolerance = 1e-6, .most_intervals = 6});
  EXPECT_FALSE(limited.reached);
  EXPECT_NE(limited.message.find("stopped with 6 intervals per phase, the limit is 6"),
            std::string::npos)
      << limited.message;
}

// Only one of two phases needs refinement.
TEST(Refinement, RefinesOnlyWhereNecessary) {
  Phase<2, 1> phase = block(), after{"after", Cart{}, exactly(0.5)};
  phase.keep("ceiling", height, at_most(0.2));
  after.minimise("effort", effort).keep("low", height, at_most(5.0));
  OptimalControlProblem ocp = bryson_denham(phase);
  const RefinedSolution r = solve_refined(ocp.then(after), intervals(5), *ipopt());
  EXPECT_TRUE(r.reached) << r.message;
  EXPECT_NEAR(r.solution.cost, 2.24, 1e-8);          // with a node at the top the ramps are exact
  EXPECT_EQ(r.intervals, (std::vector<int>{8, 5}));  // the third is divided into four
}

// If a window ends within a phase of free duration, its intervals stay equal.
TEST(Refinement, FreeDurationWithAWindowDividesAllIntervals) {
  Phase<2, 1> phase{"climb", Cart{}, between(0.6, 2.0)};
  phase.minimise("effort", effort)
      .minimise_at_end("time", [](auto t, const auto&) { return 0.1 * t; })
      .keep("ceiling", height, at_most(0.1), Window{.to = 0.5})
      .reach("there", height, exactly(1.0))
      .guess_duration(1.0);
  OptimalControlProblem ocp("climb");
  ocp.start_at({0, 1}).then(phase).costs(CostRule::integrated);
  const RefinedSolution r =
      solve_refined(ocp, intervals(5), *ipopt(), {.tolerance = 1e-4, .rounds = 3});
  ASSERT_GT(r.violations.size(), 1u) << r.message;
  EXPECT_LT(r.violations.back(), r.violations.front());
  EXPECT_EQ(r.intervals.front() % 5, 0);
}

TEST(Refinement, ReportsUnsolvableProblems) {
  Phase<2, 1> phase = block();
  phase.keep("ceiling", height, at_most(0.2)).keep("floor", height, at_least(0.3));
  const RefinedSolution r = solve_refined(bryson_denham(phase), intervals(5), *ipopt());
  EXPECT_FALSE(r.reached);
  EXPECT_FALSE(r.solution.ok());
  EXPECT_NE(r.message.find("on the first grid failed"), std::string::npos) << r.message;
}

}  // namespace
}  // namespace saltus
