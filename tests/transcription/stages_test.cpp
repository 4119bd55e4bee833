// Stages of multiple-shooting programs are equivalent for all event times, with phases, jumps, free
// durations, unknowns, ramps and change costs.
#include <gtest/gtest.h>

#include <functional>

#include "benchmarks/push_recovery_cases.hpp"
#include "problems/push_recovery/problem.hpp"
#include "saltus/qp/stage_map.hpp"
#include "tests/problems/two_gears.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/stage_checks.hpp"

namespace saltus {
namespace {

using namespace testing_support;

double uniform(std::mt19937& random) { return testing_support::uniform(random, -1.0, 1.0); }

// Linearisation of a program with respect to its variables.
qp::SparseQp linearise(NonlinearProgram& nlp, const VectorXd& w) {
  qp::SparseQp qp(nlp.hessian_pattern(), nlp.jacobian_pattern());
  const VectorXd lambda = VectorXd::Zero(nlp.rows());
  VectorXd c(nlp.rows());
  EXPECT_TRUE(nlp.gradient(w.data(), qp.gradient.data()));
  EXPECT_TRUE(nlp.constraints(w.data(), c.data()));
  EXPECT_TRUE(nlp.jacobian(w.data(), qp.rows.data()));
  EXPECT_TRUE(nlp.hessian(w.data(), 1.0, lambda.data(), qp.hessian.data(), Curvature::exact));
  qp.hessian_pattern.for_each([&](int a, int b, int e) {
    qp.gradient[a] -= qp.hessian[e] * w[b];
    if (a != b) qp.gradient[b] -= qp.hessian[e] * w[a];
  });
  qp.row_pattern.for_each([&](int r, int v, int e) { c[r] -= qp.rows[e] * w[v]; });
  qp.lower = nlp.lower();
  qp.upper = nlp.upper();
  qp.row_lower = nlp.row_lower() - c;
  qp.row_upper = nlp.row_upper() - c;
  return qp;
}

// A feasible and convex program with the same zeros, bounds and active rows, but random numbers. A
// linearised program need be neither.
void randomise(qp::SparseQp& qp, VectorXd w, std::mt19937& random) {
  // Eliminated variables have no coupling in the Hessian.
  std::vector<char> is_joined(qp.variables(), 0);
  qp.hessian_pattern.for_each([&](int a, int b, int) {
    if (a != b) is_joined[a] = is_joined[b] = 1;
  });
  const auto may_be_slack = [&](int v) {
    return qp.lower[v] == 0.0 && qp.upper[v] == infinity && !is_joined[v];
  };
  for (int v = 0; v < qp.variables(); ++v) {
    w[v] = std::clamp(w[v] + 0.1 * uniform(random), qp.lower[v], qp.upper[v]);
    if (!may_be_slack(v)) qp.gradient[v] += 0.1 * uniform(random);
  }
  qp.hessian_pattern.for_each([&](int a, int b, int e) {
    if (a != b && qp.hessian[e] != 0.0) qp.hessian[e] = uniform(random) / 40.0;
    if (a == b && !may_be_slack(a)) qp.hessian[e] = 1.5 + uniform(random);
  });
  VectorXd value = VectorXd::Zero(qp.row_pattern.rows());
  qp.row_pattern.for_each([&](int r, int v, int e) { value[r] += qp.rows[e] * w[v]; });
  for (int r = 0; r < value.size(); ++r) {
    if (qp.row_lower[r] == qp.row_upper[r]) {
      qp.row_lower[r] = qp.row_upper[r] = value[r];
      continue;
    }
    if (qp.row_lower[r] > -infinity) qp.row_lower[r] = value[r] - 0.1 - 0.1 * uniform(random);
    if (qp.row_upper[r] < infinity) qp.row_upper[r] = value[r] + 0.1 + 0.1 * uniform(random);
  }
}

void expect_stages(MultipleShooting& shooting, qp::StageMap& map, std::mt19937& random) {
  const VectorXd w = shooting.initial_guess().w;
  qp::SparseQp qp = linearise(shooting.nlp(), w);
  ASSERT_EQ(map.fill(qp), qp::StageFill::filled);
  expect_equivalent(qp, map, random);
  randomise(qp, w, random);
  ASSERT_EQ(map.fill(qp), qp::StageFill::filled);
  expect_equivalent(qp, map, random);
  expect_same_optimum(qp, map);
  qp::StageMap fresh(qp, shooting.stages());
  ASSERT_EQ(fresh.fill(qp), qp::StageFill::filled);
  expect_equal(map.stages(), fresh.stages());
}

qp::SparseQp patterns(MultipleShooting& shooting) {
  return {shooting.nlp().hessian_pattern(), shooting.nlp().jacobian_pattern()};
}

void expect_stages(const OptimalControlProblem& ocp, int intervals = 6) {
  MultipleShooting shooting(ocp, {.intervals_per_phase = intervals, .integrator = runge_kutta4()});
  qp::StageMap map(patterns(shooting), shooting.stages());
  std::mt19937 random(1);
  expect_stages(shooting, map, random);
}

// Events before the start, at it, inside the first interval, at nodes, inside, at the end, and
// beyond.
constexpr double impacts[] = {-0.05, 0.0, 0.04, 0.1, 0.4, 0.45, 0.83, 0.97, 1.0, 1.3, infinity};

// --- one phase with an event --------------------------------------------------------------------

void expect_stages_around_impact(const Phase<1, 1>& phase, CostRule rule = CostRule::nodes) {
  OptimalControlProblem ocp = with_impact(phase, 0.5);
  MultipleShooting shooting(ocp.costs(rule), ten);
  qp::StageMap map(patterns(shooting), shooting.stages());
  std::mt19937 random(2);
  for (const double impact : impacts) {
    SCOPED_TRACE(impact);
    shooting.retime("impact", impact);
    expect_stages(shooting, map, random);
  }
}

Phase<1, 1> motion() {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0})
      .bound_input(0, exactly(0.3), Window{.to = event("impact")})
      .bound_state(0, between(-4.0, 4.0), Window{.from = event("impact")})
      .keep(
          "both", [](const auto&, const auto& x, const auto& u) { return (x + u).eval(); },
          between(-2.0, 2.0), Window{.from = event("impact")});
  return phase;
}

TEST(Stages, AreEquivalentAroundAnEvent) { expect_stages_around_impact(motion()); }

TEST(Stages, AreEquivalentWithChangeCosts) {
  expect_stages_around_impact(motion().penalise_change(Vec<double, 1>{2.0}));
}

TEST(Stages, AreEquivalentWithRamps) {
  for (const InputParametrisation parametrisation :
       {InputParametrisation::piecewise_linear, InputParametrisation::piecewise_linear_continuous})
    expect_stages_around_impact(motion().inputs(parametrisation), CostRule::integrated);
}

TEST(Stages, AreEquivalentWithSoftRows) {
  for (const Penalty::Kind penalty : {Penalty::L1, Penalty::L2})
    expect_stages_around_impact(motion().keep("soft", state, between(0.2, 0.4),
                                              Window{.from = event("impact")},
                                              soft("soft", 2.0, penalty)));
}

// --- several phases -----------------------------------------------------------------------------

struct Drift {  // x' = u + p
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return u + p;
  }
};

// An unknown that the first phase does not use and the others share.
OptimalControlProblem late_unknown(Bounds bounds) {
  Phase<1, 1> first{"first", Velocity{}, exactly(1.0)};
  first.track("effort", input, Vec<double, 1>{1.0});
  Phase<1, 1, 1> second{"second", Drift{}, exactly(1.0)}, third{"third", Drift{}, exactly(0.5)};
  for (auto* phase : {&second, &third})
    phase->unknown("drift", Vec<double, 1>{0.5}, bounds, 4.0)
        .track("effort", input, Vec<double, 1>{1.0});
  third.reach("end", state, exactly(2.0));
  OptimalControlProblem ocp("late unknown");
  ocp.start_at({0}).then(first).then(
      second, jump<1>("half", [](auto, auto x) { return decltype(x)(0.5 * x); }));
  return ocp.then(third);
}

TEST(Stages, AreEquivalentWithAnUnknownOfLaterPhases) {
  const OptimalControlProblem ocp = late_unknown(between(-3.0, 3.0));
  expect_stages(ocp);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 4, .integrator = runge_kutta4()});
  qp::StageMap map(patterns(shooting), shooting.stages());
  ASSERT_EQ(map.fill(linearise(shooting.nlp(), shooting.initial_guess().w)), qp::StageFill::filled);
  EXPECT_EQ(map.stages().intervals() + 1, 15);  // 3 phases of 4 intervals; none in front
  EXPECT_EQ(map.stages().stages[3].nx, 1);
  EXPECT_EQ(map.stages().stages[4].nu, 1);  // the drift, at the jump
  EXPECT_EQ(map.stages().stages[5].nx, 2);
}

TEST(Stages, AreEquivalentWithAFixedUnknown) { expect_stages(late_unknown(exactly(0.7))); }

TEST(Stages, AreEquivalentWithFreeDurationsAndChangingSizes) {
  OptimalControlProblem ocp = two_gears::problem();
  expect_stages(ocp);
  expect_stages(ocp.total_time(at_most(25.0)));
}

// The cost of a slack depends on the duration, so the slack is not eliminated.
TEST(Stages, AreEquivalentWithSoftRowsInAPhaseOfFreeDuration) {
  for (const Penalty::Kind penalty : {Penalty::L1, Penalty::L2})
    for (const InputParametrisation parametrisation :
         {InputParametrisation::piecewise_constant, InputParametrisation::piecewise_linear}) {
      Phase<1, 1> phase{"motion", Velocity{}, between(0.5, 2.0)};
      phase.inputs(parametrisation)
          .track("effort", input, Vec<double, 1>{1.0})
          .keep("lane", state, between(0.2, 0.4), {}, soft("lane", 2.0, penalty))
          .keep("limit", input, at_least(-0.5), {}, soft("limit", 1.0, penalty))
          .reach("end", state, exactly(0.1), soft("end", 3.0, penalty))
          .minimise_at_end("time", [](auto t, auto) { return t; });
      OptimalControlProblem ocp("free and soft");
      expect_stages(ocp.start_at({1}).then(phase));
    }
}

// Stages carry the start to the end, through phases and through a jump that changes it.
TEST(Stages, AreEquivalentForAClosedProblem) {
  OptimalControlProblem ocp = late_unknown(between(-3.0, 3.0));
  ocp.start_within({between(-2.0, 2.0)}, Vec<double, 1>{0.5});
  expect_stages(ocp.close());
  expect_stages(ocp.close(jump<1, 1>(
      "drop", [](auto t, auto x, auto, auto p) { return decltype(x)(0.5 * x + t * p); })));
}

TEST(Stages, AreEquivalentForAFreeOrPartlyFreeStart) {
  for (const Bounds bounds : {between(-1.0, 1.5), exactly(1.0), unbounded()}) {
    OptimalControlProblem ocp = two_gears::problem();
    ocp.start_within({bounds, between(-0.5, 0.5)}, Vec<double, 2>{1.0, 0.0});
    expect_stages(ocp);
    OptimalControlProblem fixed_times = with_impact(motion(), 0.45);
    fixed_times.start_within({bounds}, Vec<double, 1>{1.0});
    expect_stages(fixed_times);
  }
}

// --- push recovery ------------------------------------------------------------------------------

class PushRecovery : public ::testing::Test {
 protected:
  static MultipleShooting shooting(double wrench_change, double penalty, int intervals = 15) {
    push_recovery::QpCase c = push_recovery::read_case("ICUB-1");
    c.model.intervals = intervals;
    c.weights.wrench_change = wrench_change;
    c.weights.capture_point_penalty = penalty;
    return push_recovery::transcribe(c);
  }
};

TEST_F(PushRecovery, HasEquivalentStagesForAnyImpactTime) {
  std::mt19937 random(3);
  for (const double penalty : {0.0, 10.0})
    for (const double change : {0.0, 1e-3}) {
      MultipleShooting problem = shooting(change, penalty, 6);
      if (change > 0.0) problem.set_previous_input(VectorXd::Constant(12, 1.0));
      qp::StageMap map(patterns(problem), problem.stages());
      for (const double impact :
           {-0.02, 0.0, 0.004, 0.01, 0.03, 0.043, 0.05, 0.06, 0.1, infinity}) {
        SCOPED_TRACE(impact);
        problem.retime("impact", impact);
        expect_stages(problem, map, random);
      }
    }
}

TEST_F(PushRecovery, DeclaresTheCommonResultantUnlessChangesAreCharged) {
  for (const bool charged : {false, true}) {
    MultipleShooting problem = shooting(charged ? 1e-3 : 0.0, 0.0);
    problem.retime("impact", 0.083);
    qp::StageMap map(patterns(problem), problem.stages());
    ASSERT_EQ(map.fill(linearise(problem.nlp(), problem.initial_guess().w)), qp::StageFill::filled);
    ASSERT_EQ(map.stages().intervals(), 16);
    for (int k = 0; k < 16; ++k) {
      const qp::Stage& s = map.stages().stages[k];
      EXPECT_EQ(s.nu, k < 9 ? 6 : 12) << k;
      // The input of the last interval has no change cost with a later one.
      EXPECT_EQ(s.resultant_size, charged && k < 15 ? 0 : 6) << k;
      EXPECT_EQ(s.nx, !charged || k == 0 ? 9 : k <= 9 ? 15 : 21) << k;
      for (const qp::RowGroup& g : s.groups) {  // the cones are dense in their wrench
        const bool is_cone = g.rows > 0 && g.columns.front() >= s.nx;
        EXPECT_EQ(g.columns.size(), is_cone ? 6u : g.columns.size());
      }
    }
  }
}

TEST_F(PushRecovery, FillsStagesWithoutAllocation) {
  for (const double change : {0.0, 1e-3}) {
    MultipleShooting problem = shooting(change, 10.0);
    qp::StageMap map(patterns(problem), problem.stages());
    qp::StagePoint point(map.stages());
    PrimalDualPoint sparse;
    std::vector<qp::SparseQp> programs;
    for (const double impact : {0.0, 0.05, 0.083, infinity}) {
      problem.retime("impact", impact);
      programs.push_back(linearise(problem.nlp(), problem.initial_guess().w));
    }
    map.fill(programs[0]);
    map.convert(programs[0], point, sparse);
    const testing::AllocationCount count;
    for (const qp::SparseQp& qp : programs) {
      map.fill(qp);
      map.convert(qp, sparse, point);
      map.convert(qp, point, sparse);
    }
    EXPECT_EQ(count.made(), 0);
  }
}

}  // namespace
}  // namespace saltus
