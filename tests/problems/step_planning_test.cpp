// The step problem matches its derivation, our solver finds its optimum, and the chosen plan
// captures a pendulum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "benchmarks/pendulum_walker.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::push_recovery {
namespace {

using Vector2 = Vec<double, 2>;
using robots::walking::StepPlan;

StepModel model() {
  StepModel m;
  Eigen::Matrix<double, 4, 2> corners;
  corners << -0.25, 0.13, 0.25, 0.13, 0.25, 0.31, -0.25, 0.31;
  m.reach = robots::SupportPolygon::hull(corners).half_planes(reach_rows);
  Eigen::Matrix<double, 4, 2> legs;
  legs << -0.35, -0.35, 0.35, -0.35, 0.35, 0.35, -0.35, 0.35;
  m.leg = robots::SupportPolygon::hull(legs).half_planes(reach_rows);
  m.lent = 0.005;
  m.lent_rate = 0.07;
  return m;
}

StepNow<double> on_one_foot() {
  StepNow<double> now;
  now.swing = now.aim = Vec<double, 2>(0.0, 0.15);
  now.stride << 0.0, 0.15;
  return now;
}

// At rest except for the capture point.
Vec<double, step_states> pushed(const Vector2& capture) {
  Vec<double, step_states> x = Vec<double, step_states>::Zero();
  x.segment<2>(2) = capture;
  return x;
}

const SoleCentres centres{{0.0265, 0.005}, {0.0265, -0.005}};
const Vector2 stride(0.0, 0.15);

TEST(StepProblemTest, HasCorrectDerivatives) {
  for (const bool from_two_feet : {false, true}) {
    const OptimalControlProblem problem = step_problem(model(), 2, from_two_feet);
    for (const PhaseDefinition& phase : problem.phases()) {
      std::vector<const Function*> functions{&phase.dynamics};
      for (const Term& term : phase.terms) functions.push_back(&term.function);
      for (const Function* f : functions) {
        const int n = f->inputs();
        const DerivativeReport report =
            check_derivatives(*f, VectorXd::Constant(n, -1.0), VectorXd::Constant(n, 1.0), 5, 7);
        EXPECT_TRUE(report.ok) << phase.name;
      }
    }
  }
}

// With the capture point outside the sole, so far that neither the fastest nor the farthest step
// reaches it, the minimum violation is known: the centre of pressure stays at the edge.
TEST(StepProblemTest, ViolationMatchesThePendulum) {
  StepModel m = model();
  m.lent = 1e-6;
  m.swing_speed = 5.0;
  m.leg.b.setConstant(5.0);
  StepProgram program(m, 1, false);
  const StepNow<double> now = on_one_foot();
  const double beside = 0.25;  // m
  const StepSolution& s =
      program.solve(now, pushed({0.0, beside}), between(0.01, m.swing.upper), 0.0, 30);
  ASSERT_TRUE(s.is_solved);
  const double edge = m.sole[1];
  const double at_landing =
      robots::propagate_capture_point<double>(beside, edge, now.omega, m.swing.lower);
  // One step of the integrator per quarter of the swing: (omega h)^5 / 120 of the growth.
  EXPECT_NEAR(s.missed, at_landing - 0.31 - edge, 1e-3);
  EXPECT_NEAR(s.landing[0], m.swing.lower, 1e-3);
  EXPECT_NEAR(s.place[0][1], 0.31, 1e-3);
}

// If only capture has a weight, the step lands at the capture point.
TEST(StepProblemTest, StepsOntoTheCapturePoint) {
  StepModel m = model();
  m.lent = 1e-6;
  m.sole = {1e-4, 1e-4};  // a point foot: no freedom of the centre of pressure
  m.swing = between(0.3, 0.9);
  m.weights.duration = 100.0;
  m.weights.stride = 1e-6;
  m.weights.rest = 100.0;
  m.usual_swing = 0.4;
  StepProgram program(m, 1, false);
  StepNow<double> now = on_one_foot();
  const StepSolution& s =
      program.solve(now, pushed({0.02, 0.025}), between(0.01, m.swing.upper), 0.0, 30);
  ASSERT_TRUE(s.is_solved);
  // Twice as far as the capture point, because the final rest is midway between the feet.
  const double grown = std::exp(now.omega * s.landing[0]);
  EXPECT_NEAR(s.landing[0], 0.4, 0.02);
  EXPECT_NEAR(s.place[0][0], std::min(0.25, 2.0 * 0.02 * grown), 0.01);
  EXPECT_NEAR(s.place[0][1], std::min(0.31, 2.0 * 0.025 * grown), 0.01);
}

// The capture point is outside the reduced sole of a plan with a step, but inside the full sole.
TEST(StepProblemTest, UsesTheWholeSole) {
  StepModel m = model();
  m.lent = 1e-6;
  m.sole = m.standing_sole - Vec<double, 2>(0.006, 0.006);
  const Vector2 beside(0.0, m.standing_sole[1] - 0.003);
  StepProgram standing(m, 0, false);
  EXPECT_LT(standing.solve(on_one_foot(), pushed(beside), {}, 0.0, 30).missed, 1e-4);
  m.standing_sole = m.sole;
  StepProgram with_reserve(m, 0, false);
  EXPECT_GT(with_reserve.solve(on_one_foot(), pushed(beside), {}, 0.0, 30).missed, 3e-3);
}

// Only the front of the sole is supported: a capture point above its middle is lost.
TEST(StepProblemTest, PlansWithTheSupportedPartOfASole) {
  StepModel m = model();
  m.lent = 1e-6;
  StepNow<double> now = on_one_foot();
  now.stance_support << 0.05, 0.0, m.standing_sole[0] - 0.02, 0.0;
  now.other_support = now.stance_support;
  StepProgram standing(m, 0, false);
  const StepSolution& s = standing.solve(now, pushed({0.05, 0.0}), {}, 0.0, 30);
  EXPECT_LT(s.missed, 1e-4);
  EXPECT_NEAR(s.pressure[0], 0.05, 0.02);
  EXPECT_GT(standing.solve(now, pushed({0.0, 0.0}), {}, 0.0, 30).missed, 0.03);
}

class AgainstIpopt : public ::testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(AgainstIpopt, FindsTheSameOptimum) {
  const auto [steps, from_two_feet] = GetParam();
  const StepModel m = model();
  StepProgram program(m, steps, from_two_feet);
  StepNow<double> now = on_one_foot();
  if (from_two_feet) now.other = now.swing;
  const Vec<double, step_states> x =
      pushed(from_two_feet ? Vector2(0.11, 0.02) : Vector2(0.03, 0.07));
  const Bounds first = from_two_feet ? m.unloading : between(0.01, m.swing.upper);
  const StepSolution& s = program.solve(now, x, steps == 0 ? Bounds{} : first, 0.0, 60);
  ASSERT_TRUE(s.is_solved);

  OptimalControlProblem problem = step_problem(m, steps, from_two_feet);
  problem.start_at(x);
  ShootingOptions grid = step_grid(problem);
  MultipleShooting shooting(std::move(problem), std::move(grid));
  shooting.set_data("now", now);
  const auto ipopt = make_ipopt({.tolerance = 1e-9});
  const Solution reference = solve(shooting, *ipopt);
  ASSERT_TRUE(reference.kkt.scaled() < 1e-6) << reference.message;
  // The real-time iteration stops when a step moves by 1e-3 of the nominal magnitudes.
  EXPECT_NEAR(s.cost, reference.cost, 1e-2 * (1.0 + reference.cost));
  if (steps > 0) {
    const int swing = from_two_feet ? 1 : 0;
    EXPECT_NEAR(s.landing[0] - s.lift_off[0], reference.durations[swing], 0.01);
  }
}
INSTANTIATE_TEST_SUITE_P(Steps, AgainstIpopt,
                         ::testing::Combine(::testing::Values(0, 1, 2), ::testing::Bool()));

WalkerOptions walker_on(bool left, bool right) {
  WalkerOptions options;
  options.left_stands = left;
  options.right_stands = right;
  options.lent = model().lent;
  options.lent_rate = model().lent_rate;
  return options;
}

PendulumPush push_of(double impulse, double degrees) {
  const double angle = degrees * std::numbers::pi / 180.0;
  return {0.2, 0.1, impulse * Vector2(std::cos(angle), std::sin(angle))};
}

TEST(StepChoiceTest, StepsFasterForLargerPushes) {
  StepChoice planner(model(), {}, centres, stride);
  double before = infinity;
  for (const double impulse : {3.0, 6.0, 8.0, 10.0}) {
    planner.restart();
    const PendulumPush push = push_of(impulse, -90.0);
    const WalkerRun run = walk(planner, walker_on(true, false), {&push, 1});
    EXPECT_TRUE(run.recovered) << impulse;
    EXPECT_EQ(run.steps, impulse < 4.0 ? 0 : 1) << impulse;
    if (impulse > 4.0) {
      EXPECT_LT(run.first_landing, before) << impulse;
      before = run.first_landing;
    }
    EXPECT_LT(run.foot_speed, 1.3 * model().swing_speed) << impulse;
  }
}

TEST(StepChoiceTest, RecoversFromPushesInAllDirections) {
  StepChoice planner(model(), {}, centres, stride);
  for (const auto& [left, right] : {std::pair{true, false}, {false, true}, {true, true}})
    for (int k = 0; k < 16; ++k) {
      planner.restart();
      // Achievable in any direction: towards the stance side, one foot must suffice.
      const double away = (left ? -1.0 : 1.0) * std::sin(2.0 * std::numbers::pi * k / 16.0);
      const double impulse = left && right ? 9.0 : away > 0.3 ? 7.0 : 3.0;
      const PendulumPush push = push_of(impulse, 22.5 * k);
      const WalkerRun run = walk(planner, walker_on(left, right), {&push, 1});
      EXPECT_TRUE(run.recovered) << left << right << " " << 22.5 * k;
    }
}

StepModel walking_model() {
  StepModel m = model();
  m.usual_swing = 0.35;
  m.weights.support = 1.0;
  return m;
}

TEST(StepChoiceTest, WalksAtTheRequestedVelocityThenStands) {
  constexpr double velocity = 0.1, until = 6.0;
  StepChoice planner(walking_model(), {.velocity = {velocity, 0.0, 0.0}, .walk_until = until},
                     centres, stride);
  for (const double begin : {infinity, 3.0, 3.25}) {  // without a push, and in both halves
    planner.restart();
    WalkerOptions options = walker_on(true, true);
    options.duration = until + 3.0;
    PendulumPush push = push_of(4.0, 90.0);
    push.start = begin;
    Vector2 from = Vector2::Zero(), to = Vector2::Zero();
    double last_flight = 0.0;
    const WalkerRun run =
        walk(planner, options, {&push, 1}, [&](const StepSituation& now, const StepPlan& plan) {
          if (now.time < 2.0) from = now.gamma.head<2>();
          if (now.time < until) to = now.gamma.head<2>();
          if (!now.left.stands || !now.right.stands) last_flight = now.time;
          EXPECT_TRUE(plan.is_feasible) << now.time;
        });
    EXPECT_TRUE(run.recovered) << begin;
    EXPECT_GT(run.steps, 10) << begin;
    // Tolerance: one step more or less in four seconds, and lateral sway.
    EXPECT_NEAR((to - from)[0], velocity * (until - 2.0), 0.05) << begin;
    EXPECT_LT(std::abs((to - from)[1]), begin < infinity ? 0.12 : 0.08) << begin;
    EXPECT_LT(last_flight, until + 1.5) << begin;
  }
}

// A foot whose swing has begun when the walk ends still lands ahead. Otherwise its target would
// jump back by 4 cm.
TEST(StepChoiceTest, EndsTheLastSwingAsPlanned) {
  for (const double until : {4.0, 4.1, 4.2, 4.3, 4.4}) {
    StepChoice planner(walking_model(), {.velocity = {0.1, 0.0, 0.0}, .walk_until = until}, centres,
                       stride);
    WalkerOptions options = walker_on(true, true);
    options.duration = until + 0.5;
    std::optional<StepPlan::Step> before;  // the step of the swing in which the walk ends
    walk(planner, options, {}, [&](const StepSituation& now, const StepPlan& plan) {
      const bool is_swinging = now.left.stands != now.right.stands;
      if (now.time < until || !is_swinging) before.reset();
      if (!is_swinging || plan.count == 0) return;
      if (now.time < until) before = plan.steps[0];
      if (!before) return;
      EXPECT_NEAR(plan.steps[0].landing, before->landing, 0.02) << until << ", " << now.time;
      EXPECT_NEAR(plan.steps[0].place[0], before->place[0], 0.01) << until << ", " << now.time;
    });
  }
}

// Feet land alternately, each turned against the other one, beside each other on a circle.
TEST(StepChoiceTest, TurnsAtTheRequestedRate) {
  constexpr double until = 8.0;
  for (const double rate : {-0.2, 0.1, 0.2})
    for (const double forward : {0.0, 0.1}) {
      StepChoice planner(walking_model(), {.velocity = {forward, 0.0, rate}, .walk_until = until},
                         centres, stride);
      WalkerOptions options = walker_on(true, true);
      options.duration = until + 3.0;
      const auto yaw = [](const robots::SoleFrame& sole) {
        return std::atan2(sole.rotation(1, 0), sole.rotation(0, 0));
      };
      double begin = 0.0, end = 0.0, last = 0.0, widest = 0.0;
      const WalkerRun run =
          walk(planner, options, {}, [&](const StepSituation& now, const StepPlan& plan) {
            const double left = yaw(now.left.sole), right = yaw(now.right.sole);
            for (int k = 0; k < plan.count; ++k) ASSERT_TRUE(plan.steps[k].heading.has_value());
            if (now.time < 2.0) begin = 0.5 * (left + right);
            if (now.time < until) end = 0.5 * (left + right);
            if (now.left.stands && now.right.stands) last = left - right;
            const auto centre = [&](robots::Side side) {
              const robots::SoleFrame& sole = now.foot(side).sole;
              const Vector2& of = centres.of(side);
              return Vec<double, 3>(sole.position +
                                    sole.rotation * Vec<double, 3>(of[0], of[1], 0));
            };
            const double apart = (centre(robots::Side::left) - centre(robots::Side::right)).norm();
            if (now.left.stands && now.right.stands) widest = std::max(widest, apart);
          });
      EXPECT_TRUE(run.recovered) << rate << ", " << forward;
      // Tolerance: one step more or less in six seconds.
      EXPECT_NEAR(end - begin, rate * (until - 2.0), std::abs(0.5 * rate)) << forward;
      EXPECT_LT(std::abs(last), std::abs(0.5 * rate)) << forward;  // at most one turn
      EXPECT_LT(widest, std::hypot(stride[1], forward * 0.45) + 0.03) << rate << ", " << forward;
    }
}

// Without a yaw rate, feet keep their headings.
TEST(StepChoiceTest, PlansNoHeadingWithoutAYawRate) {
  StepChoice planner(walking_model(), {.velocity = {0.1, 0.0, 0.0}}, centres, stride);
  WalkerOptions options = walker_on(true, true);
  options.duration = 1.0;
  walk(planner, options, {}, [&](const StepSituation&, const StepPlan& plan) {
    for (int k = 0; k < plan.count; ++k) EXPECT_FALSE(plan.steps[k].heading.has_value());
  });
}

TEST(StepChoiceTest, BringsAFootBackOnRequest) {
  for (const bool is_asked : {false, true}) {
    StepChoice planner(walking_model(), {.bring_back = is_asked}, centres, stride);
    WalkerOptions options = walker_on(true, true);
    options.apart = 0.22;
    Vec<double, 3> apart = Vec<double, 3>::Zero();
    const WalkerRun run =
        walk(planner, options, {}, [&](const StepSituation& now, const StepPlan&) {
          apart = now.left.sole.position - now.right.sole.position;
        });
    EXPECT_TRUE(run.recovered);
    EXPECT_EQ(run.steps, is_asked ? 1 : 0);
    EXPECT_NEAR(apart[1], is_asked ? stride[1] - 0.01 : 0.22, 0.01);
    EXPECT_NEAR(apart[0], 0.0, 0.01);
  }
}

TEST(StepChoiceTest, IsSymmetricUnderReflection) {
  StepChoice planner(model(), {}, centres, stride);
  std::array<double, 2> landing{};
  for (int i = 0; i < 2; ++i) {
    planner.restart();
    const PendulumPush push = push_of(7.0, i == 0 ? -80.0 : 80.0);
    const WalkerRun run = walk(planner, walker_on(i == 0, i == 1), {&push, 1});
    EXPECT_TRUE(run.recovered);
    landing[i] = run.first_landing;
  }
  EXPECT_NEAR(landing[0], landing[1], 1e-6);
}

TEST(StepChoiceTest, DoesNotAllocateAndRejectsNan) {
  StepChoice planner(model(), {.most_steps = 3}, centres, stride);
  StepSituation now;
  now.mass = 33.0;
  now.omega = 4.2;
  now.right.sole.position << 0.0, -0.14, 0.0;
  now.gamma << 0.03, -0.07, 0.55, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  planner.plan(now);  // warm
  const testing::AllocationCount allocations;
  int stepping = 0;
  for (int k = 1; k < 60; ++k) {
    now.time = 0.01 * k;
    if (k == 5) now.gamma[3] = 0.45;
    if (k == 20) now.right.stands = false, now.right.lifted_off = now.time;
    const StepPlan& plan = planner.plan(now);
    stepping += plan.is_stepping();
    EXPECT_LE(plan.alternatives, StepPlan::most_alternatives);
  }
  EXPECT_EQ(allocations.made(), 0);
  EXPECT_GT(stepping, 40);
  const StepPlan before = planner.plan(now);
  now.gamma[4] = std::numeric_limits<double>::quiet_NaN();
  now.time += 0.01;
  const StepPlan& after = planner.plan(now);
  EXPECT_EQ(after.count, before.count);
  EXPECT_EQ(after.steps[0].landing, before.steps[0].landing);
  EXPECT_EQ(after.steps[0].place, before.steps[0].place);
}

TEST(StepChoiceTest, ReportsInfeasibility) {
  StepChoice planner(model(), {}, centres, stride);
  StepSituation now;
  now.mass = 33.0;
  now.omega = 4.2;
  now.right.sole.position << 0.0, -0.14, 0.0;
  now.right.stands = false;
  now.gamma << 0.03, 0.0, 0.55, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  planner.plan(now);
  EXPECT_TRUE(planner.is_feasible());
  now.time = 0.01;
  now.gamma[4] = -3.0;  // m/s
  const StepPlan& plan = planner.plan(now);
  EXPECT_FALSE(planner.is_feasible());
  EXPECT_GE(plan.chosen, 0);  // the plan with the smallest violation is used
}

}  // namespace
}  // namespace saltus::push_recovery
