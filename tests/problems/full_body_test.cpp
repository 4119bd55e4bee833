// Push recovery on the whole body in DART. Needs the URDF file named by SALTUS_ICUB_URDF.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "saltus/core/error.hpp"
#include "tests/problems/icub_in_dart.hpp"
#include "tests/support/errors.hpp"

namespace saltus::push_recovery {
namespace {

using FullBody = IcubInDart;

TEST_F(FullBody, RecoversWithAStep) {
  config.push.impulse = 6.0;
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  EXPECT_EQ(log.control_failures, 0);
  // Lands at the planned time within two planner periods.
  EXPECT_NEAR(log.touchdown, config.push.start + config.step.duration, 0.04);
  const Vec<double, 3> stance = log.body.back().left_sole.translation();
  EXPECT_LT(stance.norm(), 0.01);  // the stance foot did not slip
  for (std::size_t i = 0; i < log.body.size(); ++i)
    ASSERT_LT(log.body[i].torques.cwiseAbs().maxCoeff(), 56.0) << log.samples[i].time;  // Nm
  // The impulses of ground, weight and push equal the change of momentum, so samples miss no force.
  // The first sample covers one engine step.
  const double mass = log.floating.total_mass, engine_step = config.plant.engine.step;
  const double period = config.control.period;
  Vec<double, 3> impulse = Vec<double, 3>::Zero();
  for (std::size_t i = 0; i < log.body.size(); ++i) {
    const double span = i == 0 ? engine_step : period;
    impulse +=
        span * (log.body[i].left.head<3>() + log.body[i].right.head<3>() + log.samples[i].push -
                Vec<double, 3>(0.0, 0.0, mass * robots::standard_gravity));
  }
  const Vec<double, 3> gained =
      mass * (log.samples.back().gamma - log.samples.front().gamma).segment<3>(3);
  EXPECT_LT((impulse - gained).norm(), 0.01 * config.push.impulse) << impulse.transpose();  // N s
}

// Yaw of both soles and of the base since the start, rad.
std::array<double, 3> turned(const RunLog& log) {
  const auto yaw = [](const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
    const Mat<double, 3, 3> turn = to.linear() * from.linear().transpose();
    return std::atan2(turn(1, 0), turn(0, 0));
  };
  const RunLog::BodySample &first = log.body.front(), &last = log.body.back();
  return {yaw(first.left_sole, last.left_sole), yaw(first.right_sole, last.right_sole),
          yaw(first.state.base, last.state.base)};
}

TEST_F(FullBody, TurnsOnTheSpot) {
  constexpr double rate = 0.2, duration = 3.5;
  apply({"plant=dart", "stance=both", "step.planner=ocp", "walk.velocity=0,0,0.2",
         "walk.duration=3.5", "push.impulse=0"});
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  EXPECT_LT(log.body.back().left_sole.translation().norm(), 0.08);
  const auto [left, right, base] = turned(log);
  // The first foot lifts off after 0.4 s. Tolerance: one landing more or less.
  EXPECT_NEAR(0.5 * (left + right), rate * (duration - 0.4), 0.1);
  EXPECT_LT(std::abs(left - right), 0.11);  // the turn of one landing, 0.5 s after the last one
  EXPECT_NEAR(base, 0.5 * (left + right), 0.03);
}

// The sensors show the slope, and the swing foot lands parallel to it.
TEST_F(FullBody, WalksUpASlope) {
  constexpr double slope = 0.07;  // 4 degrees
  apply({"plant=dart", "stance=both", "step.planner=ocp", "walk.velocity=0.1,0,0",
         "walk.duration=4.5", "push.impulse=0", "simulator.ground_ahead=true",
         "simulator.ground_edge_m=0.2", "simulator.ground_slope_forward=0.07"});
  const RunLog log = run();
  EXPECT_FALSE(log.stopped_early);
  const RunLog::BodySample& last = log.body.back();
  for (const Eigen::Isometry3d& sole : {last.left_sole, last.right_sole}) {
    EXPECT_NEAR(sole.linear()(2, 0), std::sin(std::atan(slope)), 2e-3);
    EXPECT_GT(sole.translation()[0], 0.32);
  }
  // Angle between estimated and true vertical; it was the angle of the slope.
  ASSERT_TRUE(last.estimate.has_value());
  const Vec<double, 3> up = last.state.base.linear().row(2).transpose(),
                       estimated = last.estimate->state.base.linear().row(2).transpose();
  EXPECT_LT(up.cross(estimated).norm(), 0.25 * slope);
}

// A foot lands with its toe on the step and its heel in the air.
TEST_F(FullBody, WalksOntoAnUnannouncedStep) {
  constexpr double height = 0.005;  // m
  apply({"plant=dart", "stance=both", "step.planner=ocp", "walk.velocity=0.1,0,0",
         "walk.duration=4.5", "push.impulse=0", "simulator.ground_ahead=true",
         "simulator.ground_edge_m=0.2", "simulator.ground_step_m=0.005"});
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  const RunLog::BodySample& last = log.body.back();
  for (const Eigen::Isometry3d& sole : {last.left_sole, last.right_sole}) {
    EXPECT_GT(sole.translation()[0], 0.26);  // the heel is beyond the edge
    EXPECT_NEAR(sole.translation()[2], height, 2e-3);
  }
}

// Legs cannot cross, so no step helps. The pendulum without angular momentum survives 6 N s.
TEST_F(FullBody, StandsAfterAPushToTheStanceSide) {
  apply({"plant=dart", "push.start=0.5", "push.impulse=7", "push.direction=0,1,0"});
  EXPECT_FALSE(run().stopped_early);
  apply({"plant=dart", "push.start=0.5", "push.impulse=7", "push.direction=0,1,0",
         "mpc.capturing_momentum=0"});
  EXPECT_TRUE(run().stopped_early);  // falls
}

TEST_F(FullBody, MomentumControlStepsToo) {
  config.push.impulse = 4.5;  // N s; above, the angular momentum is close to the limit
  config.control.choice = robots::WholeBodyController::Method::momentum;
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  EXPECT_EQ(log.control_failures, 0);
  EXPECT_NEAR(log.touchdown, config.push.start + config.step.duration, 0.06);
}

TEST_F(FullBody, RightStanceIsTheMirrorImageOfLeftStance) {
  config.push.impulse = 6.0;
  const RunLog left = run();
  config.scene.stance = robots::Stance::right;
  config.push.direction[1] *= -1.0;
  const RunLog right = run();
  EXPECT_TRUE(judge(config, right).recovered) << judge(config, right).reason;
  const auto farthest = [](const RunLog& log, double side) {
    double y = 0.0;
    for (const BipedSample& s : log.samples) y = std::max(y, side * s.capture_point[1]);
    return y;
  };
  // The push moves the capture point by more than 0.1 m.
  EXPECT_GT(farthest(right, 1.0), 0.1);
  EXPECT_NEAR(farthest(left, -1.0), farthest(right, 1.0), 0.005);
  EXPECT_NEAR(left.touchdown, right.touchdown, 0.010);
  EXPECT_LT(right.body.back().right_sole.translation().norm(), 0.01);  // did not move
  EXPECT_GT(right.body.back().left_sole.translation()[1], 0.1);
}

TEST_F(FullBody, ReportsAFallWithoutAStep) {
  config.push.impulse = 8.0;
  config.step.allowed = false;
  const RunLog log = run();
  EXPECT_TRUE(log.stopped_early);
  EXPECT_FALSE(judge(config, log).recovered);
  EXPECT_NE(log.stop_reason.find("fell at"), std::string::npos);
}

TEST_F(FullBody, RejectsAnUnknownPushLink) {
  config.push.link = "chast";
  expect_error<InputError>([&] { run(); }, {"did you mean \"chest\"?"});
}

}  // namespace
}  // namespace saltus::push_recovery
