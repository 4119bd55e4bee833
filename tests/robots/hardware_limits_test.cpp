// Limits of the hardware: each one is found, with its first time and worst value.
#include "saltus/robots/walking/hardware_limits.hpp"

#include <gtest/gtest.h>

namespace saltus::robots::walking {
namespace {

constexpr double period = 0.002;  // s

// A robot with one joint at rest, for ten samples.
RunLog at_rest() {
  RunLog log;
  log.robot.foot_sensor_range = (Vec<double, 6>() << 1500, 1500, 2000, 35, 35, 25).finished();
  log.floating.bodies.resize(2);
  FloatingRobot::Body& body = log.floating.bodies[1];
  body.joint = "knee";
  body.effort = 40.0;
  body.velocity = 8.0;
  body.position = between(-2.0, 0.1);
  body.drive.no_load_speed = 8.0;
  for (int k = 0; k < 10; ++k) {
    BipedSample s;
    s.time = k * period;
    log.samples.push_back(s);
    RunLog::BodySample b;
    b.state.q = b.state.dq = b.torques = VectorXd::Zero(1);
    b.left = b.right = Vec<double, 6>::Zero();
    b.left_sole = b.right_sole = Eigen::Isometry3d::Identity();
    log.body.push_back(b);
  }
  return log;
}

// Expects a single excess.
void expect_one(const RunLog& log, const std::string& what, double time, double first,
                double worst) {
  const std::vector<HardwareExcess> found = hardware_excesses(log);
  ASSERT_EQ(found.size(), 1u) << what;
  EXPECT_EQ(found[0].what, what);
  EXPECT_NEAR(found[0].time, time, 1e-12) << what;
  EXPECT_NEAR(found[0].first, first, 1e-12) << what;
  EXPECT_NEAR(found[0].worst, worst, 1e-12) << what;
}

TEST(HardwareLimits, ARobotAtRestKeepsThem) {
  EXPECT_TRUE(hardware_excesses(at_rest()).empty());
  EXPECT_TRUE(hardware_excesses({}).empty());
}

TEST(HardwareLimits, FindsForcesAndMomentsOnTheFeet) {
  RunLog log = at_rest();
  log.body[3].right[2] = 2100.0;
  log.body[4].right[2] = 2500.0;
  expect_one(log, "vertical force on the right foot", 3 * period, 2100.0, 2500.0);
  EXPECT_EQ(describe(hardware_excesses(log)[0]),
            "at 0.006 s the vertical force on the right foot was 2100 N (limit 2000)");
  log = at_rest();
  log.body[5].left[4] = -36.0;
  expect_one(log, "tipping moment on the left foot", 5 * period, 36.0, 36.0);
}

TEST(HardwareLimits, FindsSpeedsAndPositionsOfJoints) {
  RunLog log = at_rest();
  log.body[2].state.dq[0] = -8.5;
  expect_one(log, "speed of knee", 2 * period, 8.5, 8.5);
  log = at_rest();
  log.body[7].state.q[0] = 0.15;
  expect_one(log, "position of knee beyond its limit", 7 * period, 0.05, 0.05);
}

TEST(HardwareLimits, FindsTorquesBeyondTheTorqueSpeedLine) {
  RunLog log = at_rest();
  for (RunLog::BodySample& b : log.body) {
    b.state.dq[0] = 4.0;
    b.torques[0] = -40.0;  // braking
  }
  EXPECT_TRUE(hardware_excesses(log).empty());
  log.body[6].torques[0] = 25.0;
  expect_one(log, "torque of knee at its speed", 6 * period, 25.0, 25.0);
}

TEST(HardwareLimits, AreSortedByTime) {
  RunLog log = at_rest();
  log.body[2].state.dq[0] = -8.5;
  log.body[1].left[2] = 2100.0;
  const std::vector<HardwareExcess> found = hardware_excesses(log);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].what, "vertical force on the left foot");
  EXPECT_EQ(found[1].what, "speed of knee");
}

TEST(LandingSpeed, IsThatOfTheLastStepBeforeTheTouch) {
  RunLog log = at_rest();
  for (int k = 0; k < 10; ++k) {
    log.body[k].left_sole.translation()[2] = k < 6 ? 0.2 * period * (6 - k) : 0.0;
    log.body[k].left[2] = k < 6 ? 0.0 : 100.0;
  }
  EXPECT_NEAR(landing_speed(log), 0.2, 1e-9);
  EXPECT_EQ(landing_speed(at_rest()), 0.0);
}

}  // namespace
}  // namespace saltus::robots::walking
