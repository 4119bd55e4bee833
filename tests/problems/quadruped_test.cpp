// The quadruped: physics of its body, edits of its contact schedule, and the closed loop. This
// program does not link the robots library.
#include "problems/quadruped/quadruped.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "problems/quadruped/run.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/model/derivative_check.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::quadruped {
namespace {

constexpr Touching none{false, false, false, false}, all{true, true, true, true};

TEST(Quadruped, DerivativesOfThePlanModelAreCorrect) {
  const Gait gait({}, 0.45, 0.01);
  const OptimalControlProblem ocp = problem({}, {}, gait.legs_apart());
  const Function& dynamics = ocp.phases().front().dynamics;
  const int n = dynamics.inputs();
  VectorXd upper = VectorXd::Constant(n, 0.4);
  upper.segment(1 + states, 3 * legs).setConstant(100.0);  // forces, N
  const DerivativeReport report = check_derivatives(dynamics, -upper, upper, 5, 3);
  EXPECT_TRUE(report.ok) << report;
}

// Without forces, the CoM is in free fall and the angular momentum is constant in the world frame.
TEST(Quadruped, FreeBodyKeepsItsAngularMomentum) {
  const Body body;
  State<double> x = State<double>::Zero();
  x.tail<6>() << 0.3, -0.2, 0.5, 1.0, -2.0, 1.5;
  const auto momentum = [&](const State<double>& at) {
    return (rotation(at) * body.inertia.cwiseProduct(at.tail<3>())).eval();
  };
  IntegratorPlant plant = make_plant<states, 0>(
      [body](const auto&, const auto& at) {
        using S = std::decay_t<decltype(at[0])>;
        return rate<S>(body, at, PerLeg<S>::Zero().eval(), PerLeg<S>::Zero().eval());
      },
      runge_kutta4({.steps = 200}), x);
  ASSERT_TRUE(plant.advance(VectorXd(0), 0.5)) << plant.failure();
  const State<double> end = plant.state();
  constexpr double integrated = 1e-8;  // error of the scheme
  EXPECT_NEAR(end[2], -0.5 * gravity * 0.25, integrated);
  EXPECT_LT((momentum(end) - momentum(x)).norm(), integrated);
  EXPECT_GT((end.tail<3>() - x.tail<3>()).norm(), 0.1);  // it tumbles
}

// In the air: the lateral momentum comes only from the push, for any split of the interval.
TEST(Quadruped, PushHasItsImpulseForAnyStart) {
  for (const double begin : {1.0, 1.01, 1.013})
    for (const double duration : {0.1, 0.05, 0.01, 0.003}) {
      const PlantSettings settings;
      RobotOnGround robot(settings, Ground(), 0.29);
      const Pulse push{1.0, Vec<double, 3>(1.0, -2.0, 0.0), begin, duration};
      ASSERT_TRUE(robot.take_pulses({&push, 1}));
      std::array<LegCommand, legs> up;
      for (LegCommand& command : up) command = {true, {0.0, 0.0, 5.0}};
      robot.command(up);
      for (int k = 0; k < 60; ++k)
        ASSERT_TRUE(robot.advance(VectorXd::Zero(3 * legs), 0.02)) << robot.failure();
      const Vec<double, 3> gained = settings.body.mass * robot.state().segment<3>(3);
      EXPECT_NEAR(gained[0], 1.0, 1e-9) << begin << " s, for " << duration << " s";
      EXPECT_NEAR(gained[1], -2.0, 1e-9) << begin << " s, for " << duration << " s";
    }
}

// FL and RR lift at 0.3 s and are due at 0.5025 s; FR and RL lift at 0.525 s.
Gait after(double seconds, bool blind, const Touching& at_the_end) {
  GaitSettings settings;
  settings.blind = blind;
  Gait gait(settings, 0.45, 0.01);
  const int ticks = static_cast<int>(std::lround(seconds / 0.01));
  for (int k = 0; k < ticks; ++k)
    gait.update(0.01 * k, k < 31 ? all : Touching{false, true, true, false});
  gait.update(0.01 * ticks, at_the_end);
  return gait;
}

TEST(Quadruped, EarlyTouchdownStartsStance) {
  const Touching early{true, true, true, false};
  const Gait seeing = after(0.45, false, early), blind = after(0.45, true, early);
  EXPECT_TRUE(seeing.stands(0));
  EXPECT_FALSE(seeing.stands(3));  // the other one still swings
  EXPECT_EQ(seeing.early(), 1);
  EXPECT_EQ(seeing.contacts().mode_at(0.46), "FL FR RL -");
  EXPECT_NEAR(seeing.next_lift(1), 0.525, 1e-12);  // no other lift-off time has changed
  EXPECT_NEAR(seeing.next_lift(0), 0.75, 1e-12);
  EXPECT_FALSE(blind.stands(0));
}

TEST(Quadruped, WaitsForALateFoot) {
  const Touching late{false, true, true, true};
  const Gait seeing = after(0.52, false, late), blind = after(0.52, true, late);
  EXPECT_FALSE(seeing.stands(0));
  EXPECT_TRUE(seeing.stands(3));
  EXPECT_NEAR(seeing.next_landing(0), 0.53, 1e-12);
  EXPECT_GE(seeing.next_lift(1), 0.53 - 1e-12);  // no foot lifts earlier
  EXPECT_GT(seeing.waited(), 0.0);
  EXPECT_TRUE(blind.stands(0));
  EXPECT_NEAR(blind.next_lift(1), 0.525, 1e-12);
  EXPECT_EQ(blind.waited(), 0.0);
}

TEST(Quadruped, IgnoresTouchdownsInTheFirstHalfOfTheSwing) {
  EXPECT_FALSE(after(0.38, false, all).stands(0));
}

// Front feet on a slope of 45 degrees. A foot that moves up, but faster into the hill, has not
// lifted off.
TEST(Quadruped, FootLeavesASlopeOnlyWhenMovingAway) {
  constexpr double k = 10.0;  // rad/m
  Ground hill;
  hill.waves[0] = {k, 0.0, -k * Body{}.hip(0)[0], 1.0 / k};
  RobotOnGround robot({}, hill, 0.29);
  std::array<LegCommand, legs> commands;
  commands.fill({false, {0.0, 0.0, -0.1}});
  commands[0] = {true, {1.0, 0.0, 0.5}};
  robot.command(commands);
  ASSERT_TRUE(robot.advance(VectorXd::Zero(3 * legs), 0.01)) << robot.failure();
  EXPECT_TRUE(robot.touching()[0]);
  commands[0].velocity[2] = 1.5;
  robot.command(commands);
  ASSERT_TRUE(robot.advance(VectorXd::Zero(3 * legs), 0.01)) << robot.failure();
  EXPECT_FALSE(robot.touching()[0]);
}

Config short_run(double seconds, double size) {
  Config config;
  config.duration = seconds;
  config.scale = size;
  return config;
}

TEST(Quadruped, TrotsAtTheRequestedSpeedOnLevelGround) {
  const RunLog level = run(short_run(3.0, 0.0));
  EXPECT_FALSE(level.fell) << level.message();
  EXPECT_EQ(level.early + level.late, 0);
  EXPECT_LT(level.farthest, 0.05);
  EXPECT_NEAR(level.log.final_state()[0], 3.0 * 0.4, 0.1);
  EXPECT_EQ(level.log.count(Provenance::shifted) + level.log.count(Provenance::fallback), 0);
}

// Both controllers have the same ground and push.
TEST(Quadruped, ContactSensingPreventsAFallOnUnevenGround) {
  const Config config = short_run(2.2, 1.5);
  const RunLog seeing = run(disturbed(config, 8, false)), blind = run(disturbed(config, 8, true));
  EXPECT_FALSE(seeing.fell) << seeing.message();
  EXPECT_GT(seeing.early, 0);
  EXPECT_GT(seeing.late, 0);
  EXPECT_TRUE(blind.fell);
}

TEST(Quadruped, RunsAreRepeatable) {
  const Config config = disturbed(short_run(0.6, 0.5), 3, false);
  EXPECT_EQ(run(config).log.final_state(), run(config).log.final_state());
}

// Edits of the schedule, footholds, data and the tick itself.
TEST(Quadruped, TickDoesNotAllocate) {
  Controller controller{ControllerSettings{}};
  PerLeg<double> feet = PerLeg<double>::Zero();
  for (int leg = 0; leg < legs; ++leg) feet.col(leg) = Body{}.hip(leg);
  State<double> x = State<double>::Zero();
  x[2] = 0.29;
  const VectorXd measured = x;
  const testing::AllocationCount count;
  for (int k = 0; k < 120; ++k) {
    const bool touches = k % 7 < 4;  // independent of the foot positions
    controller.observe(0.01 * k, x, feet, {touches, true, true, !touches});
    controller.planner().tick(0.01 * k, measured);
  }
  EXPECT_EQ(count.made(), 0);
}

}  // namespace
}  // namespace saltus::quadruped
