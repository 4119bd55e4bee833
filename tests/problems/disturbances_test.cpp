// Disturbances of the whole body in DART: the step must still recover from 6 N s. Needs the URDF
// file named by SALTUS_ICUB_URDF.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/robots/walking/push.hpp"
#include "tests/problems/icub_in_dart.hpp"

namespace saltus::push_recovery {
namespace {

class Disturbed : public IcubInDart {
 protected:
  void SetUp() override {
    IcubInDart::SetUp();
    config.push.impulse = 6.0;
  }
  void expect_recovery() const {
    const RunLog log = run();
    const Verdict verdict = judge(config, log);
    EXPECT_TRUE(verdict.recovered) << verdict.reason;
    EXPECT_EQ(log.control_failures, 0);
    EXPECT_LT(log.touchdown, infinity);
  }
};

// Noise of 1 mm, 0.1 degrees and 2 % of the forces. The noise of the velocities is the error of
// the slope of a line fitted to 90 ms of such measurements, 2 ms apart: sigma sqrt(12 / 45) / 0.09
// s.
TEST_F(Disturbed, RecoversDespiteNoiseAndDelay) {
  config.plant.noise = {.position = 1e-3,
                        .angle = 1.75e-3,
                        .velocity = 0.006,
                        .angular_velocity = 0.01,
                        .force = 0.02};
  config.plant.delay_ticks = 1;
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  // The log has the simulated state: between two samples 2 ms apart the CoM moves by less than its
  // speed allows, which 1 mm of noise would exceed.
  constexpr double fastest = 0.6;  // m/s
  for (std::size_t i = 1; i < log.samples.size(); ++i)
    ASSERT_LT((log.samples[i].gamma - log.samples[i - 1].gamma).head<3>().norm(),
              fastest * config.control.period)
        << log.samples[i].time;
}

// Required accuracy of the estimate, relative to the stance sole: 5 mm, and 0.02 m/s rms.
TEST_F(Disturbed, RecoversWithMeasuredSensors) {
  config.plant.sensors = PlantSettings::Sensors::measured;
  config.push.start = 0.5;  // s; the estimate of the base's tilt has converged
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  EXPECT_LT(log.touchdown, infinity);
  double squares = 0.0;
  long count = 0;
  for (std::size_t i = 0; i < log.body.size(); ++i) {
    if (log.samples[i].time < config.push.start) continue;
    const RunLog::BodySample& b = log.body[i];
    ASSERT_TRUE(b.estimate);
    const Vec<double, 9> error = b.estimate->gamma - log.samples[i].gamma;
    const Vec<double, 3> sole = b.estimate->stance_sole - b.left_sole.translation();
    ASSERT_LT((error.head<3>() - sole).norm(), 5e-3) << log.samples[i].time;
    squares += error.segment<3>(3).squaredNorm();
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 0.02);
}

TEST_F(Disturbed, RecoversWithAHeavierNominalRobot) {
  config.robot.mass_error = 0.03;  // with 0.05 the stance foot turns: a corner slips by 11 mm
  expect_recovery();
}

TEST_F(Disturbed, RecoversWithALighterNominalRobot) {
  config.robot.mass_error = -0.05;
  expect_recovery();
}

// Without the estimate the CoM ends 15 mm from its target. Biases of the force sensors are 2 N and
// 0.1 Nm, the tilt of the base is uncertain.
TEST_F(Disturbed, EstimatesMassAndCom) {
  apply({"plant=dart", "push.impulse=7", "push.start=1", "model.mass_error=0.1",
         "model.com_error=[0.01, 0.01, 0]"});
  EXPECT_TRUE(config.mass_estimate.is_estimated);
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  EXPECT_LT(verdict.final_com_error, 5e-3);
  ASSERT_TRUE(log.mass_estimate.has_value());
  const RunLog::MassEstimate found = log.mass_estimate.value_or(RunLog::MassEstimate());
  EXPECT_NEAR(found.mass, log.robot.mass, 0.01 * log.robot.mass);
  EXPECT_LT((found.com_shift.head<2>() + config.robot.com_error.head<2>()).norm(), 3e-3);
}

// With straight knees the landing has four weights.
TEST_F(Disturbed, RecoversWithRealDrives) {
  apply({"plant=dart", "drives=real", "sensor.seed=7", "push.impulse=10", "push.start=1"});
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  ASSERT_TRUE(verdict.body.has_value());
  EXPECT_LT(verdict.body->landing_force, 3.0 * log.robot.mass * standard_gravity);
}

// Springs and play of iCub's legs. The controllers take the drives for rigid.
TEST_F(Disturbed, RecoversWithElasticDrives) {
  apply({"plant=dart", "drives=real", "drive.elasticity=1", "drive.backlash=1", "push.impulse=7",
         "push.start=1"});
  const Verdict verdict = judge(config, run());
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  // 350 Nm/rad are too soft for these controllers, which shows that the springs act.
  apply({"drive.elasticity=28.6"});
  EXPECT_FALSE(judge(config, run()).recovered);
}

// The inner part of the sole lands on an edge, or the whole sole on a slope. With a weak hold of
// the stance feet (300 1/s^2) the robot keeps moving on the slope.
TEST_F(Disturbed, RecoversOnPartOfTheSoleAndOnASlope) {
  for (const char* ground :
       {"simulator.ground_step_m=-0.02", "simulator.ground_slope_side=-0.08"}) {
    config = {};
    apply({"plant=dart", "drives=real", "push.impulse=7", "push.start=1", "sensor.seed=2", ground});
    if (config.plant.engine.ground.slope_side != 0.0) config.plant.engine.ground.edge = 0.11;
    const RunLog log = run();
    const Verdict verdict = judge(config, log);
    EXPECT_TRUE(verdict.recovered) << ground << ": " << verdict.reason;
    // The verdict is about the whole soles, not about the parts that the controller estimates.
    EXPECT_EQ(log.final_scene.rectangle(robots::Side::left), log.robot.left_foot);
    EXPECT_EQ(log.final_scene.rectangle(robots::Side::right), log.robot.right_foot);
  }
}

TEST_F(Disturbed, RecoversOnSlipperyGround) {
  config.plant.engine.friction = 0.4;
  expect_recovery();
}

// The foot touches the ground early or late. The landing is at the actual contact.
TEST_F(Disturbed, RecoversOnGroundOfUnexpectedHeight) {
  const RunLog level = run();
  constexpr double step = 0.01;  // m
  for (const double height : {step, -step}) {
    config.plant.engine.ground.height = height;
    const RunLog log = run();
    const Verdict verdict = judge(config, log);
    EXPECT_TRUE(verdict.recovered) << height << ": " << verdict.reason;
    if (height > 0.0)
      EXPECT_LT(log.touchdown, level.touchdown - 0.01);  // a period of the planner
    else
      EXPECT_GT(log.touchdown, level.touchdown + 0.01);
    // The foot rests there; contacts penetrate by 1 to 2 mm.
    EXPECT_NEAR(log.body.back().right_sole.translation()[2], height, 0.002);
    EXPECT_NEAR(log.body.back().left_sole.translation()[2], 0.0, 0.002);
  }
}

// The foot lands with its inner or its outer edge first, and rests flat on the slope.
TEST_F(Disturbed, RecoversOnASlopeThatRisesToTheSide) {
  for (const char* slope : {"0.04", "-0.04"}) {
    apply({fmt::format("simulator.ground_slope_side={}", slope)});
    const RunLog log = run();
    const Verdict verdict = judge(config, log);
    EXPECT_TRUE(verdict.recovered) << slope << ": " << verdict.reason;
    const Eigen::Isometry3d& sole = log.body.back().right_sole;
    const double height = config.plant.engine.ground.slope_side * (-sole.translation()[1] - 0.24);
    EXPECT_NEAR(sole.translation()[2], height, 0.002);
    EXPECT_NEAR(sole(1, 2), config.plant.engine.ground.slope_side, 0.005);  // the normal
    EXPECT_NEAR(log.body.back().left_sole.translation()[2], 0.0, 0.002);
  }
}

// 120 N for 0.05 s and 30 N for 0.2 s.
TEST_F(Disturbed, RecoversFromAShortHardPush) {
  config.push.duration = 0.05;
  expect_recovery();
}

TEST_F(Disturbed, RecoversFromALongSoftPush) {
  config.push.duration = 0.2;
  expect_recovery();
}

TEST_F(Disturbed, RecoversFromAPushOfAnotherShape) {
  config.push.shape = PulseShape::half_sine;
  expect_recovery();
}

constexpr double rounding = 1e-12;

TEST(Push, EveryShapeHasTheImpulseForAnySteps) {
  for (const PulseShape shape :
       {PulseShape::rectangle, PulseShape::half_sine, PulseShape::triangle})
    for (const double step : {0.001, 0.0037, 0.05}) {
      Push push;
      push.shape = shape;
      push.start = 0.0123;
      Vec<double, 3> sum = Vec<double, 3>::Zero();
      for (int k = 0; k * step < 0.2; ++k) sum += step * push.mean(k * step, (k + 1) * step);
      EXPECT_LT((sum - push.impulse * push.direction).norm(), rounding) << describe(shape);
    }
}

TEST(Push, ShapesMatchTheirNames) {
  Push push;
  push.impulse = 6.0;
  const auto force_at = [&push](double fraction) {
    constexpr double dt = 1e-6;  // s
    const double t = push.start + fraction * push.duration;
    return push.mean(t - 0.5 * dt, t + 0.5 * dt).norm();
  };
  constexpr double difference = 1e-3;  // N, of a mean over dt
  EXPECT_NEAR(force_at(0.25), 60.0, difference);
  EXPECT_EQ(force_at(-0.1), 0.0);
  EXPECT_EQ(force_at(1.1), 0.0);
  push.shape = PulseShape::half_sine;
  const double peak = 0.5 * std::acos(-1.0) * 60.0;
  EXPECT_NEAR(force_at(0.5), peak, difference);
  EXPECT_NEAR(force_at(1.0 / 6.0), 0.5 * peak, difference);
  push.shape = PulseShape::triangle;
  EXPECT_NEAR(force_at(0.25), 60.0, difference);
  EXPECT_NEAR(force_at(0.75), 60.0, difference);
  EXPECT_NEAR(force_at(0.4), 96.0, difference);
}

}  // namespace
}  // namespace saltus::push_recovery
