// Soft terms against closed forms: the violated terms, the violation and its cost.
#include <gtest/gtest.h>

#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/shooting_program.hpp"
#include "tests/support/event_problems.hpp"

namespace saltus {
namespace {

using namespace testing_support;

// min int 1/2 u^2 over one second, x' = u from 1 with a penalty on x(1) > 0: u is constant, and
// u = -min(multiplier, ...) follows from the optimality of 1/2 u^2 + penalty(1 + u).
Solution solve_soft_end(Penalty penalty) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0}).reach("stop", state, at_most(0.0), penalty);
  OptimalControlProblem ocp("soft end");
  ocp.start_at({1}).then(phase);
  MultipleShooting shooting(ocp, ten);
  return solve(shooting, *make_ipopt({.tolerance = 1e-10}));
}

TEST(SoftEnd, L1BelowTheMultiplierIsViolatedByTheExpectedAmount) {
  const Solution s = solve_soft_end(soft("stop", 0.4));  // u = -weight
  ASSERT_TRUE(s.ok()) << s.message;
  ASSERT_EQ(s.soft_violations.size(), 1u);
  EXPECT_EQ(s.soft_violations[0].phase, "motion");
  EXPECT_EQ(s.soft_violations[0].term, "stop");
  EXPECT_NEAR(s.soft_violations[0].largest, 0.6, 1e-7);
  EXPECT_NEAR(s.soft_violations[0].time, 1.0, 1e-12);
  EXPECT_NEAR(s.cost, 0.5 * 0.16 + 0.4 * 0.6, 1e-7);
  EXPECT_LT(s.kkt.scaled(), 1e-8);
}

TEST(SoftEnd, L1AboveTheMultiplierIsExact) {
  const Solution s = solve_soft_end(soft("stop", 1.5));  // the hard multiplier is 1
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_LT(s.soft_violations[0].largest, 1e-7);
  EXPECT_NEAR(s.cost, 0.5, 1e-7);
}

TEST(SoftEnd, L2IsAlwaysViolated) {
  for (const double weight : {0.5, 3.0, 100.0}) {
    const Solution s = solve_soft_end(soft("stop", weight, Penalty::L2));
    ASSERT_TRUE(s.ok()) << s.message;
    const double violation = 1.0 / (1.0 + weight);  // solves min 1/2 (1 - v)^2 + weight/2 v^2
    EXPECT_NEAR(s.soft_violations[0].largest, violation, 1e-7);
    EXPECT_NEAR(s.cost, 0.5 * weight / (1.0 + weight), 1e-7);
  }
}

TEST(SoftEnd, BothSidesAreSoft) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0})
      .reach("go to 3", state, exactly(3.0), soft("target", 1.0, Penalty::L2));
  OptimalControlProblem ocp("soft target");
  ocp.start_at({1}).then(phase);
  MultipleShooting shooting(ocp, ten);
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.soft_violations[0].largest, 1.0, 1e-7);  // 2 / (1 + weight)
  EXPECT_NEAR(s.trajectory.final_state()[0], 2.0, 1e-7);
}

// A running penalty is a cost per unit of time, so an empty rest of its window costs nothing.
TEST(SoftRunning, WindowAtTheEndCostsNothing) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0})
      .keep("low", state, at_most(0.0), Window{.from = event("impact")}, soft("low", 3.0));
  MultipleShooting shooting(with_impact(phase, 0.9), ten);
  const auto cost = [&] { return solve(shooting, *make_ipopt({.tolerance = 1e-10})).cost; };
  EXPECT_GT(cost(), 0.1);  // 0.3 of weight for a last tenth of a second
  shooting.retime("impact", 1.0);
  EXPECT_NEAR(cost(), 0.0, 1e-9);
}

// With a free duration, the cost of a slack depends on the length of its interval. A block with one
// output computes it if any interval has such a cost.
TEST(SoftRunning, SlacksOutsideTheWindowAreFree) {
  Phase<1, 1> phase{"motion", Velocity{}, between(0.5, 2.0)};
  phase.guess_duration(1.0).keep("low", state, at_most(0.0), Window{.to = 0.3}, soft("low", 3.0));
  OptimalControlProblem ocp("free");
  ocp.start_at({1}).then(phase);
  MultipleShooting shooting(ocp, ten);
  const ShootingProgram& program = shooting.program();
  int charged = 0, free = 0;
  for (const shooting::RowInstance& instance : program.row_instances()) {
    const int block = program.penalty_block(instance.slack_above[0]);
    if (shooting.grid().node_offset(0, instance.block.point.node) > 0.3 + same_instant) {
      EXPECT_EQ(block, -1);
      ++free;
    } else {
      ASSERT_GE(block, 0);
      EXPECT_EQ(program.block_outputs(block), 1);
      ++charged;
    }
  }
  EXPECT_EQ(charged, 4);  // nodes at 0, 0.1, 0.2 and 0.3 s
  EXPECT_EQ(free, 7);
}

// --- Huber --------------------------------------------------------------------------------------

enum class Method { ipopt, riccati };

Solution solve_with(MultipleShooting& shooting, Method method) {
  if (method == Method::ipopt) return solve(shooting, *make_ipopt({.tolerance = 1e-11}));
  return solve(shooting, *make_native_solver({.tolerance = 1e-10, .qp = riccati_qp()}));
}

// min 1/2 (1 - v)^2 + penalty(v). Within the threshold it equals L2, and beyond it the slope is
// constant.
TEST(SoftHuber, IsQuadraticThenLinear) {
  for (const Method method : {Method::ipopt, Method::riccati})
    for (const double threshold : {0.1, 0.3, 0.6, 2.0})
      for (const double weight : {0.5, 1.5, 20.0}) {
        const Penalty penalty = huber("stop", weight, threshold);
        Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
        phase.track("effort", input, Vec<double, 1>{1.0})
            .reach("stop", state, at_most(0.0), penalty);
        OptimalControlProblem ocp("Huber at the end");
        MultipleShooting shooting(ocp.start_at({1}).then(phase), ten);
        const Solution s = solve_with(shooting, method);
        ASSERT_TRUE(s.ok()) << s.message;
        const double near = 1.0 / (1.0 + weight), far = 1.0 - weight * threshold;
        const double violation = near <= threshold ? near : far;
        const double paid = cost(penalty, violation);
        SCOPED_TRACE(weight * 1000 + threshold);
        EXPECT_NEAR(s.soft_violations[0].largest, violation, 1e-7);
        EXPECT_NEAR(s.cost, 0.5 * (1.0 - violation) * (1.0 - violation) + paid, 1e-8);
        EXPECT_NEAR(s.costs[1].value, paid, 1e-7);
        EXPECT_LT(s.kkt.scaled(), 1e-8);
        EXPECT_LT(kkt_residual(shooting.nlp(), s.point).scaled(), 1e-8);
      }
}

// Both sides at once, and a change of weight between solves. x tracks 3 and violates the soft
// limit.
TEST(SoftHuber, ActsOnBothSidesWithAChangingWeight) {
  for (const double target : {3.0, -1.0}) {
    Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
    phase.track("effort", input, Vec<double, 1>{1.0})
        .reach("go", state, exactly(target), huber("target", 5.0, 0.5));
    OptimalControlProblem ocp("Huber target");
    MultipleShooting shooting(ocp.start_at({1}).then(phase), ten);
    for (const Method method : {Method::ipopt, Method::riccati})
      for (const double weight : {1.0, 5.0}) {
        shooting.set_penalty_weight("target", weight);
        const Solution s = solve_with(shooting, method);
        ASSERT_TRUE(s.ok()) << s.message;
        const double near = 2.0 / (1.0 + weight), far = 2.0 - 0.5 * weight;
        EXPECT_NEAR(s.soft_violations[0].largest, near <= 0.5 ? near : far, 1e-7);
      }
  }
}

TEST(SoftHuber, NeedsAThreshold) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.reach("stop", state, at_most(0.0), soft("stop", 1.0, Penalty::Huber));
  OptimalControlProblem ocp("no threshold");
  ocp.start_at({1}).then(phase);
  EXPECT_THROW(MultipleShooting(ocp, ten), DefinitionError);
}

// A penalty of any kind equals the minimum cost of its slacks, which the program minimises.
TEST(Penalties, AreTheMinimumCostOfTheirSlacks) {
  for (const Penalty& penalty :
       {soft("a", 1.7), soft("b", 0.6, Penalty::L2), huber("c", 2.0, 0.3)}) {
    const Penalty::Slacks slacks = penalty_slacks(penalty);
    const auto cost_of = [](const Penalty::SlackCost& c, double s) {
      return c.is_quadratic ? 0.5 * c.weight * s * s : c.weight * s;
    };
    for (const double v : {0.0, 0.1, 0.3, 0.31, 1.0, 4.0}) {
      double least = cost_of(slacks.side, v);
      constexpr int steps = 4000;
      for (int i = 0; slacks.free && i <= steps; ++i) {
        const double r = v * i / steps;
        least = std::min(least, cost_of(slacks.side, v - r) + cost_of(*slacks.free, r));
      }
      EXPECT_NEAR(cost(penalty, v), least, 1e-5 * (1.0 + v)) << penalty.name << " at " << v;
    }
  }
}

// A penalty is exact if its slope at zero is positive.
TEST(Penalties, AreExactIfTheirCostHasASlopeAtZero) {
  for (const Penalty& penalty : {soft("a", 1.7), soft("b", 0.6, Penalty::L2), huber("c", 2.0, 0.3)})
    EXPECT_EQ(is_exact(penalty), cost(penalty, 1e-6) / 1e-6 > 0.1 * penalty.weight) << penalty.name;
  EXPECT_TRUE(is_exact(soft("a", 1.7)));
}

// The input has no effect, so x stays at 1. The penalty is per unit of time.
struct Frozen {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>&) const {
    return Vec<S, 1>::Zero();
  }
};

Solution solve_frozen(Penalty::Kind penalty, int intervals, double impact) {
  Phase<1, 1> phase{"frozen", Frozen{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0})
      .keep("below", state, at_most(0.8), Window{.from = event("impact")},
            soft("below", 3.0, penalty));
  MultipleShooting shooting(with_impact(phase, impact),
                            {.intervals_per_phase = intervals, .integrator = runge_kutta4()});
  return solve(shooting, *make_ipopt({.tolerance = 1e-10}));
}

TEST(SoftRunning, CostIsAnIntegralOverTime) {
  for (const int n : {10, 20, 40}) {
    const Solution l1 = solve_frozen(Penalty::L1, n, -1.0), l2 = solve_frozen(Penalty::L2, n, -1.0);
    ASSERT_TRUE(l1.ok() && l2.ok()) << l1.message << l2.message;
    // The given start has no row. The end counts with the last interval.
    EXPECT_NEAR(l1.cost, 3.0 * 0.2, 1e-6);
    EXPECT_NEAR(l2.cost, 1.5 * 0.04, 1e-6);
    EXPECT_NEAR(l1.soft_violations[0].largest, 0.2, 1e-6);
  }
}

TEST(SoftRunning, WindowOnTheEventChangesTheCostContinuously) {
  const double h = 0.1;
  double before = 0.0;
  for (int i = 0; i <= 40; ++i) {
    const double impact = 0.48 + 0.001 * i;
    const Solution s = solve_frozen(Penalty::L1, 10, impact);
    ASSERT_TRUE(s.ok()) << s.message;
    // There is one more node than intervals. The last node counts again with the last interval.
    EXPECT_NEAR(s.cost, 0.6 * (1.0 - impact + h), 1e-6) << impact;
    if (i > 0) {
      EXPECT_NEAR(s.cost, before, 0.6 * 0.001 + 1e-6);
    }
    before = s.cost;
  }
}

TEST(SoftRunning, BeyondTheHorizonCostsNothing) {
  const Solution s = solve_frozen(Penalty::L1, 10, 1.5);
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.cost, 0.0, 1e-9);
  EXPECT_NEAR(s.soft_violations[0].largest, 0.0, 1e-9);
}

TEST(SoftWeights, ChangeBetweenSolvesByName) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0})
      .reach("stop", state, at_most(0.0), soft("stop", 0.4));
  OptimalControlProblem ocp("soft end");
  MultipleShooting shooting(ocp.start_at({1}).then(phase), ten);
  const auto solver = make_ipopt({.tolerance = 1e-10});
  shooting.set_penalty_weight("stop", 0.7);
  EXPECT_NEAR(solve(shooting, *solver).soft_violations[0].largest, 0.3, 1e-7);
}

TEST(SoftCosts, AreIncludedInTheTotal) {
  const Solution s = solve_soft_end(soft("stop", 0.4));
  ASSERT_EQ(s.costs.size(), 2u);
  EXPECT_EQ(s.costs[1].term, "stop");
  EXPECT_NEAR(s.costs[1].value, 0.24, 1e-6);
  EXPECT_NEAR(s.costs[0].value, 0.08, 1e-6);
}

// --- free durations -----------------------------------------------------------------------------

// x rests at 1 outside the lane x <= 0 and costs per second 0.5 (L1), 0.25 (L2) or 0.16 (Huber).
// The other cost is 1 / T, so T = sqrt(1 / rate), far from the guess.
TEST(SoftRunning, CostFollowsTheFreeDuration) {
  for (const Penalty::Kind kind : {Penalty::L1, Penalty::L2, Penalty::Huber}) {
    const Penalty penalty{kind, 0.5, "lane", 0.4};
    for (const bool of_input : {false, true}) {
      Phase<1, 1> phase{"wait", Velocity{}, between(0.2, 9.0)};
      phase.bound_input(0, exactly(0.0))
          .guess_duration(0.7)
          .minimise_at_end("haste", [](auto t, auto) { return 1.0 / t; });
      if (of_input)
        phase.keep(
            "lane", [](auto, auto x, auto u) { return decltype(x)(x + u); }, at_most(0.0), {},
            penalty);
      else
        phase.keep("lane", state, at_most(0.0), {}, penalty);
      OptimalControlProblem ocp("waiting");
      // The start has bounds, so that it has a row.
      ocp.start_within({between(1.0, 2.0)}, Vec<double, 1>{1.0}).then(phase);
      MultipleShooting shooting(ocp, ten);
      const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-11}));
      ASSERT_TRUE(s.ok()) << s.message;
      const double rate = cost(penalty, 1.0);
      // Rows on a state exist at both ends of the phase. The last one counts again with the last of
      // the ten intervals.
      const double paid = of_input ? rate : 1.1 * rate;
      EXPECT_NEAR(s.durations[0], std::sqrt(1.0 / paid), 1e-6);
      EXPECT_NEAR(s.cost, 2.0 * std::sqrt(paid), 1e-8);
      ASSERT_EQ(s.costs.size(), 2u);
      for (const Solution::CostContribution& c : s.costs)
        EXPECT_NEAR(c.value, std::sqrt(paid), 1e-6);
      EXPECT_NEAR(s.soft_violations.front().largest, 1.0, 1e-7);
    }
  }
}

}  // namespace
}  // namespace saltus
