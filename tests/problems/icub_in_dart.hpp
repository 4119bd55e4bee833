// A short run of iCub in DART, for tests. Needs the URDF file named by SALTUS_ICUB_URDF.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "saltus/app/settings.hpp"
#include "saltus/robots/icub/icub.hpp"
#include "tests/problems/push_recovery_run.hpp"

namespace saltus::push_recovery {

class IcubInDart : public testing::Test {
 protected:
  void SetUp() override {
    urdf = std::getenv("SALTUS_ICUB_URDF");
    if (urdf == nullptr) GTEST_SKIP() << "SALTUS_ICUB_URDF does not name iCubGazeboV2_5's URDF";
    robot = icub(urdf);
    config.plant.choice = PlantSettings::Choice::dart;
    config.robot.urdf = urdf;
    config.push.start = 0.2;  // s; earlier than the default, for a short run
  }
  // Applies arguments as after `saltus run push_recovery --set`.
  void apply(const std::vector<std::string>& words) { push_recovery::apply(words, config); }
  RunLog run() const { return simulate(config, robot); }

  const char* urdf = nullptr;
  robots::RobotDescription robot;
  Config config;
};

}  // namespace saltus::push_recovery
