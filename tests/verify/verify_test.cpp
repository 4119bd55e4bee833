// The verifier on handmade plans and on plans of solvers. Each reported number is compared with a
// known value, and must not change if the problem is written differently.
#include "saltus/verify/verify.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

// From (0, 0) with a thrust of 2 m/s^2 for 1 s, in two intervals: x = t^2, v = 2 t.
Plan thrust_plan() {
  Plan plan;
  plan.intervals = {{0, 0.0, 0.5, VectorXd{{0.0, 0.0}}, VectorXd{{2.0}}, VectorXd{{0.25, 1.0}}},
                    {0, 0.5, 0.5, VectorXd{{0.25, 1.0}}, VectorXd{{2.0}}, VectorXd{{1.0, 2.0}}}};
  plan.parameters = {VectorXd()};
  plan.starts = {0.0};
  plan.durations = {1.0};
  plan.cost = 2.0;
  return plan;
}
Phase<2, 1> thrust() {
  Phase<2, 1> phase{"thrust", Cart{}, exactly(1.0)};
  phase.minimise("effort", effort).bound_input(0, between(-2.0, 2.0));
  return phase;
}
OptimalControlProblem problem_of(const Phase<2, 1>& phase) {
  OptimalControlProblem ocp("thrust");
  ocp.start_at({0, 0}).then(phase).costs(CostRule::integrated);
  return ocp;
}

TEST(Verify, AcceptsACorrectPlan) {
  Phase<2, 1> phase = thrust();
  phase.keep("slow", speed, at_most(2.0))
      .bound_state(0, between(0.0, 1.0))
      .reach("there", position, exactly(1.0))
      .bound_integral("way", speed, exactly(1.0));
  const Verification v = verify(problem_of(phase), thrust_plan()).summary;
  EXPECT_LT(v.between_nodes.amount, 1e-12);
  EXPECT_LT(v.at_nodes.amount, 1e-12);
  EXPECT_LT(v.defect.largest, 1e-12);
  EXPECT_LT(v.open_loop.states, 1e-12);
  EXPECT_TRUE(v.open_loop.completed);
  EXPECT_TRUE(v.cost.compared);
  EXPECT_NEAR(v.cost.value, 2.0, 1e-12);
  EXPECT_EQ(v.cost.difference, 0.0);
  EXPECT_TRUE(v.not_verified.empty());
  // The flow is [1 1; 0 1]: its largest singular value is the golden ratio.
  EXPECT_NEAR(v.open_loop.growth, 0.5 * (1.0 + std::sqrt(5.0)), 1e-6);
}

TEST(Verify, NamesEachKindOfMiss) {
  const Plan plan = thrust_plan();
  const auto at_nodes = [&](const Phase<2, 1>& phase) {
    return verify(problem_of(phase), plan).summary.at_nodes;
  };
  {
    Phase<2, 1> phase = thrust();
    phase.reach("there", position, exactly(1.5));
    const Verification::Miss miss = at_nodes(phase);
    EXPECT_EQ(miss.term, "there");
    EXPECT_NEAR(miss.amount, 0.5, 1e-12);
    EXPECT_NEAR(miss.tolerance, 1.5e-6, 1e-15);
    EXPECT_NEAR(miss.time, 1.0, 1e-12);
  }
  {
    Phase<2, 1> phase = thrust();
    phase.bound_input(0, at_most(1.5), Window{.from = 0.5});
    const Verification::Miss miss = at_nodes(phase);
    EXPECT_EQ(miss.term, "bounds of input 0");
    EXPECT_NEAR(miss.amount, 0.5, 1e-12);
    EXPECT_NEAR(miss.time, 0.5, 1e-12);
  }
  {
    Phase<2, 1> phase = thrust();
    phase.bound_integral("way", speed, at_most(0.75));
    const Verification::Miss miss = verify(problem_of(phase), plan).summary.between_nodes;
    EXPECT_EQ(miss.term, "integral 'way'");
    EXPECT_NEAR(miss.amount, 0.25, 1e-9);
  }
  {
    OptimalControlProblem ocp = problem_of(thrust());
    ocp.start_at({0.1, 0.0});
    EXPECT_NEAR(verify(ocp, plan).summary.at_nodes.amount, 0.1, 1e-12);
    EXPECT_EQ(verify(ocp, plan).summary.at_nodes.term, "start of state 0");
  }
  {
    Plan wrong = plan;
    wrong.cost = 2.1;
    EXPECT_NEAR(verify(problem_of(thrust()), wrong).summary.cost.difference, 0.1 / 2.1, 1e-9);
  }
  {
    Plan wrong = plan;
    wrong.intervals[0].end_state[0] = wrong.intervals[1].state[0] = 0.26;
    const VerificationDetail d = verify(problem_of(thrust()), wrong);
    EXPECT_NEAR(d.summary.defect.absolute, 0.01, 1e-9);
    EXPECT_NEAR(d.intervals[0].defect, 0.01, 1e-9);
    EXPECT_NEAR(d.summary.defect.sum, 0.02, 1e-9);
    EXPECT_LT(d.summary.open_loop.states, 1e-9);  // 0.01 too far, then too near again
  }
}

// A window applies while it is open, and the bounds between nodes are the active ones.
TEST(Verify, ChecksOpenWindows) {
  for (const double to : {0.5, 1.0}) {
    Phase<2, 1> phase = thrust();
    phase.keep("slow", speed, at_most(1.2), Window{.to = to});
    const Verification::Miss miss = verify(problem_of(phase), thrust_plan()).summary.between_nodes;
    EXPECT_NEAR(miss.amount, to > 0.5 ? 0.8 : 0.0, 1e-12);
  }
}

// |x - a| near a, sqrt at the edge of its domain, and rows that are always active.
TEST(Verify, FollowsRowsWithKinksAndActiveRows) {
  Phase<2, 1> phase = thrust();
  phase
      .keep(
          "not there", [](auto, auto x) { return abs(x[0] - 0.3); }, at_least(0.001))
      .keep(
          "root", [](auto, auto x) { return sqrt(x[0]); }, at_most(1.0))
      .keep(
          "active",
          [](auto, auto x) { return x[1] * x[1] - 4.0 * x[0] + sin(x[1]) - sin(2.0 * sqrt(x[0])); },
          between(0.0, 0.0));
  const VerificationDetail d = verify(problem_of(phase), thrust_plan());
  ASSERT_FALSE(d.violated.empty());
  EXPECT_EQ(d.violated.front().miss.term, "not there");
  EXPECT_NEAR(d.violated.front().miss.amount, 0.001, 1e-5);
  EXPECT_NEAR(d.violated.front().miss.time, std::sqrt(0.3), 1e-4);
  EXPECT_EQ(d.violated.size() > 1 && d.violated[1].miss.amount > 1e-7, false);
}

// ---- equivalent forms of a problem --------------------------------------------------------------

// A pillar in the path, with lengths in `unit` metres.
OptimalControlProblem past_pillar(double unit, bool split, double radius_for_start) {
  const double length = 10.0 / unit, r = 1.0 / unit, at = 5.2 / unit;
  const auto away = [=](auto, auto x) {
    return ((x[0] - at) * (x[0] - at) + (x[1] - 0.1 * r) * (x[1] - 0.1 * r)) / r;
  };
  const auto drift = [](auto, const auto&, const auto& u) { return u; };
  OptimalControlProblem ocp("pillar");
  ocp.start_at({0.0, radius_for_start});
  const int parts = split ? 2 : 1;
  for (int k = 0; k < parts; ++k) {
    Phase<2, 2> phase{k == 0 ? "first" : "second", drift, exactly(10.0 / parts)};
    phase.keep("pillar", away, at_least(r))
        .track(
            "effort", [](auto, auto, auto u) { return u; }, VectorXd{{unit * unit, unit * unit}})
        .guess_state(Guess::interpolate(VectorXd{{length * k / parts, 0.0}},
                                        VectorXd{{length * (k + 1) / parts, 0.0}}));
    if (k + 1 == parts)
      phase.reach("goal", [](auto, auto x) { return x; }, {exactly(length), exactly(0.0)});
    ocp.then(phase);
  }
  return ocp;
}

// The same plan in other units of length. A solver could find a different optimum there.
TEST(Verify, ScalesFindingsWithUnits) {
  const OptimalControlProblem ocp = past_pillar(1.0, false, 0.0);
  const Solution s = solve(ocp);
  const Plan plan = plan_of(ocp, s.trajectory);
  const Verification::Miss first = verify(ocp, plan).summary.between_nodes;
  EXPECT_GT(first.amount, 1e-3) << s.message;
  for (const double unit : {1e-6, 1e-3, 1e3, 1e6}) {
    Plan scaled = plan;
    for (Plan::Interval& i : scaled.intervals) {
      i.state /= unit;
      i.coefficients /= unit;
      i.end_state /= unit;
    }
    const Verification::Miss miss =
        verify(past_pillar(unit, false, 0.0), scaled).summary.between_nodes;
    // Violations below a tenth of the absolute tolerance need not be found.
    EXPECT_NEAR(miss.amount * unit, first.amount, 2e-3 * first.amount + 1e-7 * unit) << unit;
    if (miss.amount > 1e-6) {
      EXPECT_NEAR(miss.time, first.time, 1e-3);
    }
  }
}

TEST(Verify, SplittingAPhaseChangesNothing) {
  const auto violation = [](bool split) {
    const Solution s =
        solve(past_pillar(1.0, split, 0.0), {.intervals_per_phase = split ? 15 : 30});
    EXPECT_TRUE(s.verification.has_value());
    return s.verification->between_nodes.amount;
  };
  const double whole = violation(false);
  EXPECT_GT(whole, 1e-4);
  EXPECT_NEAR(violation(true), whole, 2e-3 * whole);
}

// The verifier follows events inside a phase, also in a plan made without a solver.
TEST(Verify, FollowsEventsInsideAPhase) {
  Phase<2, 1> phase{"ball", Ball{}, exactly(1.0)};
  phase
      .on(
          "bounce", [](const auto&, const auto& x) { return x[0]; }, Crossing::falling,
          [](const auto&, const auto& x) {
            return std::decay_t<decltype(x)>{0.0 * x[0], -0.5 * x[1]};
          })
      .bound_input(0, between(-1.0, 1.0))
      .minimise("effort", effort);
  OptimalControlProblem ocp("ball");
  ocp.start_at({1, 0}).then(phase).costs(CostRule::integrated);
  const Solution s = solve(ocp, {.intervals_per_phase = 5, .integrator = runge_kutta8()});
  ASSERT_TRUE(s.verification.has_value());
  EXPECT_TRUE(s.verification->not_verified.empty()) << s.message;
  EXPECT_LT(s.verification->defect.largest, 1e-8) << s.message;
  // The verifier detects a plan that ignores the ground.
  Plan wrong = plan_of(ocp, s.trajectory);
  wrong.intervals.back().end_state[0] -= 0.1;
  EXPECT_NEAR(verify(ocp, wrong).summary.defect.absolute, 0.1, 1e-6);
}

TEST(Verify, ReportsUnverifiableParts) {
  Phase<1, 1> phase{"slides",
                    [](const auto&, const auto& x, const auto& u) {
                      return std::decay_t<decltype(x)>{1.0 + 0.1 * u[0] + 0.0 * x[0]};
                    },
                    exactly(1.0)};
  phase
      .switch_at(
          "surface", [](const auto&, const auto& x) { return x[0]; },
          [](const auto&, const auto& x, const auto& u) {
            return std::decay_t<decltype(x)>{-1.0 + 0.1 * u[0] + 0.0 * x[0]};
          })
      .bound_input(0, between(-1.0, 1.0))
      .minimise("effort", effort);
  OptimalControlProblem ocp("slides");
  ocp.start_at({-0.55}).then(phase).costs(CostRule::integrated);
  const Solution s = solve(ocp, {.intervals_per_phase = 5, .integrator = runge_kutta4()});
  ASSERT_TRUE(s.verification.has_value());
  EXPECT_FALSE(s.verification->not_verified.empty());
  EXPECT_FALSE(s.verification->open_loop.completed);
  EXPECT_FALSE(s.verification->cost.compared);
  EXPECT_NE(s.message.find("not verified"), std::string::npos) << s.message;
}

// The formulas that the verifier reads do not contain algebraic states.
TEST(Verify, SupportsAlgebraicPhases) {
  Phase<1, 1, 0, 1> phase{"dae",
                          [](const auto&, const auto& x, const auto& z, const auto& u) {
                            return std::decay_t<decltype(x)>{z[0] + u[0]};
                          },
                          [](const auto&, const auto& x, const auto& z) {
                            return std::decay_t<decltype(z)>{z[0] + z[0] * z[0] * z[0] + x[0]};
                          },
                          Vec<double, 1>{0.1}, exactly(1.0)};
  phase.bound_input(0, between(-1.0, 1.0))
      .keep(
          "z", [](const auto&, const auto&, const auto& z) { return z[0]; }, at_least(-0.7))
      .minimise("effort", [](const auto&, const auto&, const auto&, const auto& u) {
        return 0.5 * u[0] * u[0];
      });
  OptimalControlProblem ocp("dae");
  ocp.start_at({1.0}).then(phase).costs(CostRule::integrated);
  const Solution s = solve(ocp);
  ASSERT_TRUE(s.verification.has_value());
  EXPECT_TRUE(s.verification->not_verified.empty()) << s.message;
  EXPECT_LT(s.verification->defect.largest, 1e-6);
  EXPECT_LT(s.verification->between_nodes.amount, 1e-6) << s.message;
}

}  // namespace
}  // namespace saltus
