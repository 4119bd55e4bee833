// The verdict on a whole body, for synthetic logs with known figures.
#include "saltus/robots/walking/body_verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "problems/push_recovery/criteria.hpp"
#include "saltus/robots/icub/icub.hpp"

namespace saltus::push_recovery {
namespace {

constexpr int samples = 100;
constexpr double period = 0.01;  // s

// At rest for one second, with one joint between -1 and 1 rad and a motor of 10 Nm.
RunLog still() {
  RunLog log;
  robots::FloatingRobot::Body base, leg;
  leg.parent = 0;
  leg.joint = "hip";
  leg.position = between(-1.0, 1.0);
  leg.effort = 10.0;
  log.floating.bodies = {base, leg};
  for (int i = 0; i < samples; ++i) {
    BipedSample s;
    s.time = i * period;
    s.gamma.setZero();
    s.gamma[2] = 0.5;
    s.capture_point.setZero();
    s.wrenches.setZero();
    s.push.setZero();
    log.samples.push_back(s);
    RunLog::BodySample b;
    b.state.q = VectorXd::Zero(1);
    b.state.dq = VectorXd::Zero(1);
    b.torques = VectorXd::Zero(1);
    b.planned.setZero();
    b.left << 0.0, 0.0, 320.0, 0.0, 0.0, 0.0;
    b.right.setZero();
    b.left_sole = b.right_sole = Eigen::Isometry3d::Identity();
    log.body.push_back(b);
  }
  return log;
}

// If a long push holds the robot away from its target, the verdict waits for the end of the push,
// also after an earlier step.
TEST(Verdict, JudgesRestAfterALongPush) {
  Config config;
  config.push.start = 1.0;
  config.push.duration = 10.0;
  RunLog log;
  log.robot = icub();
  log.touchdown = 1.6;
  log.final_scene.stance_foot = {between(-0.05, 0.1), between(-0.03, 0.04)};
  for (int i = 0; i <= 320; ++i) {
    BipedSample s;
    s.time = 0.05 * i;
    s.gamma.setZero();
    s.gamma[2] = log.robot.default_posture().com[2];
    s.gamma[0] = s.time > 1.0 && s.time < 11.0 ? 0.03 : 0.0;
    s.capture_point = s.gamma.head<2>();
    s.wrenches.setZero();
    s.push.setZero();
    log.samples.push_back(s);
  }
  EXPECT_TRUE(judge(config, log).recovered) << judge(config, log).reason;
  config.push.duration = 0.1;  // now there is no reason for the offset
  EXPECT_FALSE(judge(config, log).recovered);
}

constexpr double rounding = 1e-12;

TEST(BodyVerdict, MotionlessRobotIsStanding) {
  const Verdict::Body v = judge_body(still());
  EXPECT_TRUE(v.standing);
  EXPECT_FALSE(v.touches_joint_limit());
  EXPECT_NEAR(v.limit_margin, 1.0, rounding);
  EXPECT_EQ(v.torque_limit_fraction, 0.0);
  EXPECT_NEAR(v.force_peak[0], 320.0, rounding * 320.0);
  EXPECT_NEAR(v.tilt_max, 0.0, rounding);
}

TEST(BodyVerdict, HopIsNotStanding) {
  RunLog log = still();
  log.body[50].left_sole.translation()[2] = 0.012;  // up and down again
  const Verdict::Body v = judge_body(log);
  EXPECT_FALSE(v.standing);
  EXPECT_NEAR(v.feet_moved, 0.012, rounding);
}

TEST(BodyVerdict, StepOrFallIsNotStanding) {
  RunLog log = still();
  log.touchdown = 0.5;
  EXPECT_FALSE(judge_body(log).standing);
  log = still();
  log.stopped_early = true;
  EXPECT_FALSE(judge_body(log).standing);
}

TEST(BodyVerdict, TiltIsRelativeToTheStartAndIgnoresYaw) {
  RunLog log = still();
  const Eigen::AngleAxisd start(3.0, Vec<double, 3>(0.3, 0.4, 0.1).normalized());
  for (int i = 0; i < samples; ++i) {
    Eigen::Isometry3d& base = log.body[static_cast<std::size_t>(i)].state.base;
    base.rotate(Eigen::AngleAxisd(0.01 * i, Vec<double, 3>::UnitZ()));
    base.rotate(start);
  }
  EXPECT_NEAR(judge_body(log).tilt_max, 0.0, rounding);
  EXPECT_TRUE(judge_body(log).standing);
  const Eigen::AngleAxisd bow(0.2, Vec<double, 3>::UnitX());
  log.body[30].state.base.prerotate(bow);
  EXPECT_NEAR(judge_body(log).tilt_max, 0.2, rounding);
  EXPECT_NEAR(judge_body(log).tilt_end, 0.0, rounding);
  EXPECT_FALSE(judge_body(log).standing);  // it tilted, although it returned
}

TEST(BodyVerdict, ReportsLimitsWithTheirTime) {
  RunLog log = still();
  log.body[40].state.q[0] = -1.002;
  for (int i = 0; i < 25; ++i) log.body[static_cast<std::size_t>(i)].torques[0] = -10.0;
  const Verdict::Body v = judge_body(log);
  EXPECT_TRUE(v.touches_joint_limit());
  EXPECT_NEAR(v.limit_margin, -0.002, rounding);
  EXPECT_EQ(v.limit_joint, "hip");
  EXPECT_NEAR(v.limit_time, 0.4, rounding);
  EXPECT_NEAR(v.torque_limit_fraction, 0.25, rounding);
  EXPECT_EQ(to_json(v)["joint_limit_joint"], "hip");
}

TEST(BodyVerdict, SpeedsAreRelativeToTheirLimits) {
  RunLog log = still();
  EXPECT_EQ(judge_body(log).speed_ratio, 0.0);  // no speed limit, so no ratio
  log.floating.bodies[1].velocity = 2.0;
  log.body[10].state.dq[0] = 1.5;
  Verdict::Body v = judge_body(log);
  EXPECT_NEAR(v.speed_ratio, 0.75, rounding);
  EXPECT_EQ(v.speed_joint, "hip");
  EXPECT_NEAR(v.speed_time, 0.1, rounding);
  EXPECT_EQ(v.over_speed, 0.0);
  log.body[20].state.dq[0] = -2.5;
  for (int i = 50; i < 53; ++i) log.body[static_cast<std::size_t>(i)].state.dq[0] = 2.1;
  v = judge_body(log);
  EXPECT_NEAR(v.speed_ratio, 1.25, rounding);
  EXPECT_NEAR(v.over_speed, 3.0 * period, rounding);
  EXPECT_NEAR(to_json(v)["joint_speed_ratio_max"].get<double>(), 1.25, rounding);
}

TEST(BodyVerdict, ReportsFrictionBeyondCoulombAsAnImpulse) {
  RunLog log = still();
  log.ground_friction = 0.5;
  for (const std::size_t k : {10, 11}) log.body[k].left << 30.0, 40.0, 80.0, 0.0, 0.0, 0.0;
  log.body[12].right << 0.0, 39.0, 80.0, 0.0, 0.0, 0.0;
  const Verdict::Body v = judge_body(log);
  EXPECT_NEAR(v.friction[0], 0.625, rounding);
  EXPECT_NEAR(v.beyond_friction, 2.0 * 10.0 * period, rounding);
  EXPECT_EQ(to_json(v)["friction_beyond_ns"], v.beyond_friction);
}

// Two balls of 0.1 m, one at the base's origin, the other on an arm of 0.3 m; the joint's frame
// has another body in between, so that they are not neighbours.
TEST(BodyVerdict, ReportsClearanceWithItsTime) {
  RunLog log = still();
  EXPECT_EQ(judge_body(log).clearance, infinity);  // no shapes
  robots::FloatingRobot& robot = log.floating;
  robots::FloatingRobot::Body hand;
  hand.parent = 1;
  hand.joint = "elbow";
  hand.origin.translation() << 0.3, 0.0, 0.0;
  hand.axis = Vec<double, 3>::UnitY();
  robot.bodies.push_back(hand);
  const Vec<double, 3> end(0.3, 0.0, 0.0);
  robot.bodies[0].capsules.push_back(
      {"trunk", {Vec<double, 3>::Zero(), Vec<double, 3>::Zero(), 0.1}});
  robot.bodies[2].capsules.push_back({"hand", {end, end, 0.1}});
  robot.apart = {{0, 2}};
  for (RunLog::BodySample& b : log.body) {
    b.state.q = b.state.dq = VectorXd::Zero(2);
    b.torques = VectorXd::Zero(2);
  }
  EXPECT_NEAR(judge_body(log).clearance, 0.4, rounding);
  log.body[70].state.q[1] = std::numbers::pi;  // folded back: the balls coincide
  const Verdict::Body v = judge_body(log);
  EXPECT_NEAR(v.clearance, -0.2, rounding);
  EXPECT_EQ(v.clearance_pair, "trunk and hand");
  EXPECT_NEAR(v.clearance_time, 0.7, rounding);
  EXPECT_EQ(to_json(v)["clearance_pair"], "trunk and hand");
}

// A robot that slides has not recovered, even if it is at rest.
TEST(BodyVerdict, SlippingStanceFootIsNotARecovery) {
  Config config;
  config.push.start = 0.0;
  RunLog log = still();
  EXPECT_EQ(judge(config, log).reason, "");
  for (int i = 60; i < samples; ++i)
    log.body[static_cast<std::size_t>(i)].left_sole.translation()[0] = 0.011;
  const Verdict verdict = judge(config, log);
  EXPECT_FALSE(verdict.recovered);
  EXPECT_EQ(verdict.reason, "the left foot slipped by 11 mm");
  EXPECT_NEAR(verdict.body->slip[0], 0.011, rounding);
}

// When a foot rotates about its origin, its corners slide, the farthest corner most.
TEST(BodyVerdict, SlipIsTheLargestOfAllCorners) {
  RunLog log = still();
  log.robot.left_foot = {between(-0.05, 0.12), between(-0.03, 0.05)};
  log.body[70].left_sole.rotate(Eigen::AngleAxisd(0.1, Vec<double, 3>::UnitZ()));
  EXPECT_NEAR(judge_body(log).slip[0], 2.0 * std::sin(0.05) * std::hypot(0.12, 0.05), 1e-12);
  EXPECT_EQ(judge_body(log).slips_from[0], log.samples[70].time);
}

// A foot slides, and the robot sways much later: the slip is the reason.
TEST(BodyVerdict, ReasonIsTheEarliestCause) {
  Config config;
  config.push.start = 0.0;
  RunLog log = still();
  log.samples.back().time = 6.0;
  log.samples.back().gamma[8] = 0.2;  // not at rest
  for (int i = 60; i < samples; ++i)
    log.body[static_cast<std::size_t>(i)].left_sole.translation()[0] = 0.061;
  EXPECT_EQ(judge(config, log).reason, "the left foot slipped by 61 mm");
  log.samples[50].gamma[8] = 1.5;
  EXPECT_EQ(judge(config, log).reason, "the angular momentum reached 1.50 Nms");
  log.stopped_early = true;
  log.stop_reason = "fell at 6.00 s";
  EXPECT_EQ(judge(config, log).reason,
            "fell at 6.00 s; first, at 0.50 s, the angular momentum exceeded 1 Nms");
}

TEST(BodyVerdict, FallBeforeThePushIsMarked) {
  Config config;
  RunLog log = still();
  log.stopped_early = true;
  log.stop_reason = "fell";
  EXPECT_TRUE(judge(config, log).fell_before_push);
  config.push.start = 0.5;
  EXPECT_FALSE(judge(config, log).fell_before_push);
}

}  // namespace
}  // namespace saltus::push_recovery
