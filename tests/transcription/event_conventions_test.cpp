// The conventions at events, framework/design/conventions.md: one test per sentence.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/solve/solve.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

using namespace testing_support;
using Times = std::vector<double>;

Phase<1, 1> second() { return Phase<1, 1>{"motion", Velocity{}, exactly(1.0)}; }

void expect_times(const Times& given, const Times& expected) {
  ASSERT_EQ(given.size(), expected.size());
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_NEAR(given[i], expected[i], 1e-9);
}

// --- windows
// --------------------------------------------------------------------------------------

TEST(Window, InputWindowIsHalfOpen) {
  auto phase = second();
  phase.bound_input(0, exactly(0.0), Window{.from = 0.3, .to = 0.6});
  MultipleShooting shooting(with_impact(phase, infinity), ten);
  for (const InputBounds& b : input_bounds(shooting)) {
    const bool inside = b.from > 0.29 && b.to < 0.61;
    EXPECT_EQ(b.bounds.is_equality(), inside) << b.from;
  }
}

TEST(Window, RunningCostWindowIsHalfOpenUnderBothCostRules) {
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated}) {
    auto phase = second();
    phase.minimise("time", one, Window{.from = 0.3, .to = 0.6});
    OptimalControlProblem ocp = with_impact(phase, infinity);
    MultipleShooting shooting(ocp.costs(rule), ten);
    EXPECT_NEAR(cost_at(shooting, 1.0, 0.0), 0.3, 1e-12);
  }
}

TEST(Window, WithoutAnEndIncludesTheHorizonEnd) {
  auto phase = second();
  phase.keep("late", state, at_most(2.0), Window{.from = 0.7})
      .minimise("time", one, Window{.from = 0.7});
  MultipleShooting shooting(with_impact(phase, infinity), ten);
  expect_times(active_times(shooting, "late"), {0.7, 0.8, 0.9, 1.0});
  EXPECT_NEAR(cost_at(shooting, 1.0, 0.0), 0.3, 1e-12);
}

TEST(Window, StateConstraintHoldsAtTheLeftLimitOfTheWindowEnd) {
  auto phase = second();
  phase.keep("middle", state, at_most(2.0), Window{.from = 0.3, .to = 0.6});
  MultipleShooting shooting(with_impact(phase, infinity), ten);
  expect_times(active_times(shooting, "middle"), {0.3, 0.4, 0.5, 0.6});
}

TEST(Window, ConstraintWithInputsIsHalfOpen) {
  auto phase = second();
  phase.keep(
      "power", [](const auto&, const auto& x, const auto& u) { return x[0] * u[0]; }, at_most(2.0),
      Window{.from = 0.3, .to = 0.6});
  MultipleShooting shooting(with_impact(phase, infinity), ten);
  expect_times(active_times(shooting, "power"), {0.3, 0.4, 0.5});
}

// A window [from, to) that ends at the start of its phase is empty, because that node is the end of
// another mode. It does not constrain x+.
TEST(Window, EndBeforeOrAtThePhaseStartIsEmpty) {
  for (const double end : {0.8, 1.0 - 5e-7, 1.0, 1.0 + 5e-7, 1.2}) {
    auto then = second();
    then.keep("at first", state, at_least(2.0), Window{.to = event("e")})
        .keep("from before", state, at_least(2.0), Window{.from = event("d"), .to = event("e")})
        .bound_state(0, at_most(7.0), Window{.to = event("e")})
        .minimise("time", one, Window{.to = event("e")});
    OptimalControlProblem ocp("two phases");
    ocp.schedule(Schedule({"first", "before", "after"}, {{"d", 0.5}, {"e", end}})).start_at({1.0});
    ocp.then(second()).then(then);
    MultipleShooting shooting(ocp, ten);
    const Times in_force = end > 1.1 ? Times{1.0, 1.1, 1.2} : Times{};
    expect_times(active_times(shooting, "at first"), in_force);
    expect_times(active_times(shooting, "from before"), in_force);
    bool is_bounded = false;  // at any node of the second phase
    for (int k = 0; k <= shooting.grid().intervals(1); ++k)
      is_bounded |= std::isfinite(shooting.nlp().upper()[shooting.layout().state(1, k)]);
    EXPECT_EQ(is_bounded, end > 1.1);
  }
}

TEST(Window, OffTheGridGetsItsOwnNodes) {
  auto phase = second();
  phase.keep("middle", state, at_most(2.0), Window{.from = 0.33, .to = 0.58});
  MultipleShooting shooting(with_impact(phase, infinity), ten);
  expect_times(active_times(shooting, "middle"), {0.33, 0.4, 0.5, 0.58});
}

TEST(Window, FormulaMayLeaveItsDomainOutside) {
  auto phase = second();  // from 1 down to -1; the root exists in the first half only
  const auto root = [](const auto&, const auto& x) { return sqrt(x[0] + 0.5); };
  phase.keep("root", root, at_least(0.1), Window{.to = 0.3})
      .minimise("cost of the root", root, Window{.to = 0.3})
      .track("effort", input, Vec<double, 1>{1.0})
      .bound_input(0, exactly(-2.0), Window{.from = 0.3})
      .reach("end", state, between(-1.5, -0.9));
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated}) {
    MultipleShooting shooting(with_impact(phase, infinity).costs(rule), ten);
    const Solution solution = solve(shooting, *make_ipopt());
    EXPECT_EQ(solution.status, SolveStatus::optimal) << solution.message;
  }
}

// A cost is evaluated within its window, also after the window moves, with one thread or several.
TEST(Window, CostWindowMovesWithItsEvent) {
  auto phase = second();
  const auto root = [](const auto& t, const auto&) { return sqrt(t - 0.3); };
  phase.minimise("after", root, Window{.from = event("impact")});
  for (const int threads : {1, 3}) {
    ShootingOptions options = ten;
    options.threads = threads;
    MultipleShooting shooting(with_impact(phase, 0.72), options);
    const auto expected = [](double from) {  // closed form of the square root
      return (std::pow(0.7, 1.5) - std::pow(from - 0.3, 1.5)) / 1.5;
    };
    constexpr double by_runge_kutta = 2e-6;  // h^5 f'''' / 2880 per interval of 0.1 s
    for (const double impact : {0.72, 0.55, 0.91, 2.0, 0.5}) {
      shooting.retime("impact", impact);
      EXPECT_NEAR(cost_at(shooting, 1.0, 0.0), expected(std::min(impact, 1.0)), by_runge_kutta);
    }
  }
}

TEST(GivenStart, HasNoRows) {
  auto phase = second();
  phase.keep("everywhere", state, at_most(0.5)).bound_state(0, at_most(0.5));
  MultipleShooting shooting(with_impact(phase, infinity), ten);  // starts at 1
  EXPECT_EQ(active_times(shooting, "everywhere").size(), 10u);   // not at 0
  EXPECT_TRUE(std::isinf(shooting.nlp().upper()[shooting.layout().state(0, 0)]));
  EXPECT_EQ(shooting.nlp().upper()[shooting.layout().state(0, 1)], 0.5);
}

// The start of 1 exceeds the bound of the state. The other row reads an input, so it is imposed at
// the start too.
TEST(GivenStart, HasNoRowsOfStatesInATermThatAlsoReadsInputs) {
  auto phase = second();
  phase
      .keep("both",
            [](const auto&, const auto& x, const auto& u) {
              return Vec<std::decay_t<decltype(x[0])>, 2>(x[0], u[0]);
            },
            {at_most(0.5), between(-8.0, 1.0)})
      .track("effort", input, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("given");
  ocp.start_at({1}).then(phase);
  MultipleShooting shooting(ocp, ten);
  const auto solver = make_ipopt();
  const Solution plan = solve(shooting, *solver);
  ASSERT_TRUE(plan.ok()) << plan.message;
  EXPECT_NEAR(plan.trajectory.input(0.0)[0], -5.0, 1e-6);  // at the bound after an interval
}

TEST(FreeStart, HasRows) {
  auto phase = second();
  phase.keep("everywhere", state, at_most(0.5));
  OptimalControlProblem ocp = with_impact(phase, infinity);
  ocp.start_within({between(0.0, 1.0)}, VectorXd::Zero(1));
  MultipleShooting shooting(ocp, ten);
  EXPECT_EQ(active_times(shooting, "everywhere").size(), 11u);
}

// --- jumps
// ----------------------------------------------------------------------------------------

TEST(Jump, StateBeforeBelongsToTheOldPhaseAndStateAfterToTheNew) {
  Phase<1, 1> up{"up", Velocity{}, exactly(0.5)}, down{"down", Velocity{}, exactly(0.5)};
  up.keep("high", state, at_most(3.0)).reach("meet", state, exactly(2.0));
  down.keep("low", state, at_least(-3.0));
  for (auto* phase : {&up, &down}) phase->track("effort", input, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("jump");
  ocp.start_at({1}).then(up).then(
      down, jump<1>("flip", [](const auto&, const auto& x) { return -0.5 * x[0]; }));
  MultipleShooting shooting(ocp, ten);
  expect_times(active_times(shooting, "high"),
               {0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5});
  EXPECT_EQ(active_times(shooting, "low").size(), 11u);  // the start of the new phase is free
  const Solution solution = solve(shooting, *make_ipopt());
  ASSERT_TRUE(solution.ok()) << solution.message;
  EXPECT_NEAR(solution.trajectory.state_before(0.5)[0], 2.0, 1e-7);
  EXPECT_NEAR(solution.trajectory.state(0.5)[0], -1.0, 1e-7);
}

// --- costs at the nodes
// ---------------------------------------------------------------------------

TEST(NodeCost, WeightsEachNodeByItsInterval) {
  auto phase = second();
  phase.minimise("state", [](const auto& t, const auto& x) { return t * x[0]; })
      .bound_input(0, at_least(0.0), Window{.from = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.24).costs(CostRule::nodes), ten);
  // sum of t_k h_k over the nodes 0, 0.1, 0.2, 0.24, 0.3, ...
  double expected = 0.1 * 0.1 + 0.2 * 0.04 + 0.24 * 0.06;
  for (int k = 3; k < 10; ++k) expected += 0.1 * k * 0.1;
  EXPECT_NEAR(cost_at(shooting, 1.0, 0.0), expected, 1e-12);
}

TEST(NodeCost, FollowsAFreeDuration) {
  Phase<1, 1> phase{"free", Velocity{}, between(0.5, 2.0)};
  phase.minimise("time", one).guess_duration(1.0);
  OptimalControlProblem ocp("free");
  MultipleShooting shooting(ocp.start_at({1}).then(phase).costs(CostRule::nodes), ten);
  NlpPoint point = shooting.initial_guess();
  point.w[shooting.layout().duration(0)] = 1.7;
  double cost = 0.0;
  ASSERT_TRUE(shooting.nlp().objective(point.w.data(), cost));
  EXPECT_NEAR(cost, 1.7, 1e-12);
}

// --- positions of the event
// ------------------------------------------------------------------------

struct ImpactCase {
  const char* name;
  double time;
  Times nodes_after;  // active nodes of a state constraint from the impact on
};
class Impact : public testing::TestWithParam<ImpactCase> {
 protected:
  static OptimalControlProblem problem(double time) {
    auto phase = second();
    phase.bound_input(0, exactly(0.0), Window{.to = event("impact")})
        .bound_input(0, between(1.0, 2.0), Window{.from = event("impact")})
        .keep("after", state, at_most(9.0), Window{.from = event("impact")})
        .minimise("time after", one, Window{.from = event("impact")});
    return with_impact(phase, time);
  }
};

TEST_P(Impact, SwitchesInputsCostsAndConstraintsExactly) {
  const ImpactCase& c = GetParam();
  MultipleShooting shooting(problem(c.time), ten);
  const double at = std::clamp(c.time, 0.0, 1.0);
  double covered = 0.0;
  for (const InputBounds& b : input_bounds(shooting)) {
    covered += b.to - b.from;
    const bool after = b.from > at - 2e-6;
    EXPECT_EQ(b.bounds, after ? between(1.0, 2.0) : exactly(0.0)) << b.from;
    EXPECT_TRUE(after || b.to < at + 2e-6) << "the event lies inside [" << b.from << ", " << b.to;
  }
  EXPECT_NEAR(covered, 1.0, 1e-12);
  expect_times(active_times(shooting, "after"), c.nodes_after);
  EXPECT_NEAR(cost_at(shooting, 1.0, 0.0), 1.0 - at, 2e-6);  // an event may move by 1e-6 to a node
}

TEST_P(Impact, MovesWithoutResizing) {
  MultipleShooting fresh(problem(GetParam().time), ten), moved(problem(0.77), ten);
  moved.retime("impact", GetParam().time);
  ASSERT_EQ(moved.nlp().variables(), fresh.nlp().variables());
  EXPECT_EQ(moved.nlp().jacobian_pattern(), fresh.nlp().jacobian_pattern());
  EXPECT_EQ(moved.nlp().hessian_pattern(), fresh.nlp().hessian_pattern());
  EXPECT_EQ(moved.nlp().lower(), fresh.nlp().lower());
  EXPECT_EQ(moved.nlp().row_upper(), fresh.nlp().row_upper());
  const NlpPoint point = perturbed(fresh.nlp(), fresh.initial_guess().w, 11);
  VectorXd a(fresh.nlp().rows()), b(fresh.nlp().rows());
  ASSERT_TRUE(fresh.nlp().constraints(point.w.data(), a.data()));
  ASSERT_TRUE(moved.nlp().constraints(point.w.data(), b.data()));
  EXPECT_EQ(a, b);
}

TEST_P(Impact, LeavesDerivativesExact) {
  MultipleShooting shooting(problem(GetParam().time), ten);
  const auto errors =
      derivative_errors(shooting.nlp(), perturbed(shooting.nlp(), shooting.initial_guess().w, 5));
  EXPECT_LT(errors.gradient, 1e-8);  // linear-quadratic program: rounding only
  EXPECT_LT(errors.jacobian, 1e-8);
  EXPECT_LT(errors.hessian, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(
    Of, Impact,
    testing::Values(
        ImpactCase{"AtANode", 0.7, {0.7, 0.8, 0.9, 1.0}},
        ImpactCase{"JustBeforeANode", 0.7 - 9e-7, {0.7, 0.8, 0.9, 1.0}},
        ImpactCase{"JustAfterANode", 0.7 + 9e-7, {0.7, 0.8, 0.9, 1.0}},
        ImpactCase{"BetweenNodes", 0.72, {0.72, 0.8, 0.9, 1.0}},
        ImpactCase{"AMillisecondAfterANode", 0.701, {0.701, 0.8, 0.9, 1.0}},
        ImpactCase{"AtTheEnd", 1.0, {1.0}}, ImpactCase{"JustBeyondTheEnd", 1.0 + 1e-5, {}},
        ImpactCase{"BeyondTheHorizon", 1.3, {}}, ImpactCase{"Never", infinity, {}},
        ImpactCase{"AtTheStart", 0.0, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}},
        ImpactCase{"BeforeTheStart", -0.2, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}}),
    [](const auto& instance) { return instance.param.name; });

TEST(Impact, FollowsTheStartTime) {
  auto phase = second();
  phase.keep("after", state, at_most(9.0), Window{.from = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.74), ten);
  shooting.start_at(0.2, VectorXd::Ones(1));
  expect_times(active_times(shooting, "after"), {0.74, 0.8, 0.9, 1.0, 1.1, 1.2});
}

TEST(Impact, SnapsToANodeWithinAMicrosecond) {
  auto phase = second();
  phase.bound_input(0, exactly(0.0), Window{.to = event("impact")});
  const auto intervals = [&](double time) {
    MultipleShooting shooting(with_impact(phase, time), ten);
    return input_bounds(shooting).size();
  };
  EXPECT_EQ(intervals(0.5 + 0.9e-6), 10u);
  EXPECT_EQ(intervals(0.5 - 0.9e-6), 10u);
  EXPECT_EQ(intervals(0.5 + 1.1e-6), 11u);
  EXPECT_EQ(intervals(0.5 - 1.1e-6), 11u);
}

TEST(Impact, CostIsContinuousInItsTime) {
  auto phase = second();
  phase.bound_input(0, exactly(0.0), Window{.to = event("impact")})
      .track("state", state, Vec<double, 1>{2.0})
      .track("input", input, Vec<double, 1>{0.1})
      .track("after", state, Vec<double, 1>{5.0}, Window{.from = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.5), ten);
  const auto solver = make_ipopt();
  double before = 0.0;
  for (int i = 0; i <= 60; ++i) {
    shooting.retime("impact", 0.47 + 0.001 * i);
    const Solution solution = solve(shooting, *solver);
    ASSERT_TRUE(solution.ok()) << solution.message;
    // dJ/dt_impact is about 2 here, so a millisecond changes J by 0.002. A discontinuity would be
    // 0.1.
    if (i > 0) {
      EXPECT_LT(std::abs(solution.cost - before), 0.01) << 0.47 + 0.001 * i;
    }
    before = solution.cost;
  }
}

}  // namespace
}  // namespace saltus
