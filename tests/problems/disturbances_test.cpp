// What disturbs the whole body in DART: does the step still catch 6 N s? Needs the URDF, whose file
// SALTUS_ICUB_URDF names.
#include <gtest/gtest.h>

#include <cstdlib>

#include "problems/push_recovery/full_body.hpp"
#include "robots/icub/icub.hpp"

namespace saltus::push_recovery {
namespace {

class Disturbed : public testing::Test {
 protected:
  void SetUp() override {
    urdf = std::getenv("SALTUS_ICUB_URDF");
    if (urdf == nullptr) GTEST_SKIP() << "SALTUS_ICUB_URDF does not name iCubGazeboV2_5's URDF";
    robot = icub(urdf);
    config.plant = PlantChoice::dart;
    config.push.impulse = 6.0;
    config.push.start = 0.2;  // s; earlier than by default, to be short
  }
  RunLog run() const { return simulate_full_body(config, robot, urdf); }
  void expect_recovery() const {
    const RunLog log = run();
    const Verdict verdict = judge(config, log);
    EXPECT_TRUE(verdict.recovered) << verdict.reason;
    EXPECT_EQ(log.control_failures, 0);
    EXPECT_LT(log.touchdown, infinity);
  }

  const char* urdf = nullptr;
  RobotDescription robot;
  Config config;
};

// 1 mm, 0.1 degrees, 2 % of the forces; the velocities as a straight line through 90 ms of such
// measurements, 2 ms apart, leaves them: sigma sqrt(12 / 45) / 0.09 s.
TEST_F(Disturbed, StepCatchesAPushInSpiteOfNoiseAndDelay) {
  config.noise = {.position = 1e-3,
                  .angle = 1.75e-3,
                  .velocity = 0.006,
                  .angular_velocity = 0.01,
                  .force = 0.02};
  config.delay_ticks = 1;
  const RunLog log = run();
  const Verdict verdict = judge(config, log);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  // The log has the truth: between two samples 2 ms apart the CoM moves by less than its speed
  // allows, which 1 mm of noise would exceed.
  constexpr double fastest = 0.6;  // m/s
  for (std::size_t i = 1; i < log.samples.size(); ++i)
    ASSERT_LT((log.samples[i].gamma - log.samples[i - 1].gamma).head<3>().norm(),
              fastest * config.control_period)
        << log.samples[i].time;
}

TEST_F(Disturbed, ControllersThatBelieveInAHeavierRobot) {
  config.mass_error = 0.05;
  expect_recovery();
}

TEST_F(Disturbed, ControllersThatBelieveInALighterRobot) {
  config.mass_error = -0.05;
  expect_recovery();
}

}  // namespace
}  // namespace saltus::push_recovery
