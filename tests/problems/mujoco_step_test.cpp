// The result of a push in two engines: the step must recover in MuJoCo as in DART. Needs the URDF
// file named by SALTUS_ICUB_URDF.
#include <algorithm>

#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "tests/problems/icub_in_dart.hpp"

namespace saltus::push_recovery {
namespace {

class MujocoStep : public IcubInDart, public ::testing::WithParamInterface<double> {
 protected:
  void SetUp() override {
    if (!robots::has_mujoco()) GTEST_SKIP() << "built without MuJoCo";
    IcubInDart::SetUp();
  }
};

TEST_P(MujocoStep, RecoversAsInDart) {
  config.push.impulse = GetParam();
  config.push.start = 0.4;
  double lowest[2], touchdown[2];
  for (const int k : {0, 1}) {
    config.plant.choice = k == 0 ? PlantSettings::Choice::dart : PlantSettings::Choice::mujoco;
    const RunLog log = run();
    const Verdict verdict = judge(config, log);
    EXPECT_TRUE(verdict.recovered) << log.plant << ": " << verdict.reason;
    EXPECT_EQ(log.control_failures, 0) << log.plant;
    lowest[k] = infinity;
    for (const BipedSample& s : log.samples) lowest[k] = std::min(lowest[k], s.capture_point[1]);
    touchdown[k] = log.touchdown;
    const std::string engine = k == 0 ? "dart" : "mujoco";
    RecordProperty(engine + "_lowest_capture_point", std::to_string(lowest[k]));
    RecordProperty(engine + "_touchdown", std::to_string(touchdown[k]));
    RecordProperty(engine + "_settling", std::to_string(verdict.icp_settling));
    RecordProperty(engine + "_com_error", std::to_string(verdict.final_com_error));
    RecordProperty(engine + "_plant_seconds",
                   std::to_string(log.plant_seconds / log.samples.back().time));
  }
  // Accepted differences between the two engines.
  EXPECT_NEAR(lowest[0], lowest[1], 0.005);  // m
  // The robot recovers from the smallest push without a step.
  ASSERT_EQ(touchdown[0] < infinity, touchdown[1] < infinity);
  if (touchdown[0] < infinity) {
    EXPECT_NEAR(touchdown[0], touchdown[1], 0.020);  // s
  }
  EXPECT_TRUE(touchdown[0] < infinity || GetParam() < 5.0);
}

INSTANTIATE_TEST_SUITE_P(Push, MujocoStep, ::testing::Values(4.0, 5.0, 6.0),
                         [](const auto& p) { return std::to_string(static_cast<int>(p.param)); });

}  // namespace
}  // namespace saltus::push_recovery
