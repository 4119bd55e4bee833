// A short run of iCub in DART, for tests. Needs the URDF, whose file SALTUS_ICUB_URDF names.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/walking/full_body.hpp"

namespace saltus::push_recovery {

class IcubInDart : public testing::Test {
 protected:
  void SetUp() override {
    urdf = std::getenv("SALTUS_ICUB_URDF");
    if (urdf == nullptr) GTEST_SKIP() << "SALTUS_ICUB_URDF does not name iCubGazeboV2_5's URDF";
    robot = icub(urdf);
    config.plant = PlantChoice::dart;
    config.push.start = 0.2;  // s; earlier than by default, to be short
  }
  RunLog run() const { return simulate_full_body(config, robot, urdf); }

  const char* urdf = nullptr;
  RobotDescription robot;
  Config config;
};

}  // namespace saltus::push_recovery
