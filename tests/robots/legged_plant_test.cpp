// What the closed loop drives, asked directly: a few steps of each plant, no controller above it.
#include "saltus/robots/walking/legged_plant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "tests/app/support.hpp"
#include "tests/robots/synthetic_biped.hpp"

namespace saltus::walking {
namespace {

class LeggedPlants : public testing::Test {
 protected:
  LeggedPlants() {
    const SyntheticBiped biped;
    const RobotChoice choice{folder.file("robot.urdf", biped.urdf()).string(),
                             folder.file("robot.yaml", biped.yaml()).string()};
    urdf = choice.urdf;
    robot = robot_of(choice, true);
  }
  PlantStart start() const {
    const StandingPosture& posture = robot.default_posture();
    return {robot, posture, scene_of(posture, robot), {}};
  }
  std::unique_ptr<LeggedPlant> whole_body(const std::vector<Push>& pushes = {}) const {
    PlantSettings settings;
    settings.choice = PlantChoice::dart;
    PlantStart pushed = start();
    pushed.pushes = pushes;
    return make_whole_body_legged_plant(pushed, {urdf, {}, {}}, settings);
  }
  // On the left foot.
  Vec<double, 12> weight() const {
    Vec<double, 12> wrenches = Vec<double, 12>::Zero();
    wrenches[2] = robot.mass * standard_gravity;
    return wrenches;
  }

  TemporaryFolder folder;
  std::string urdf;
  RobotDescription robot;
};

// Control is due every 2 ms, the engine's steps take 1 ms, and the planner's ticks 10 ms.
TEST_F(LeggedPlants, AWholeBodyIsSensedWhenControlIsDue) {
  const auto plant = whole_body();
  EXPECT_EQ(plant->truth_time(), 0.0);
  EXPECT_EQ(plant->tick_time(3), 0.03);
  for (int k = 0; k < 4; ++k) {
    const double t = 0.001 * k, due_last = 0.002 * (k / 2);
    EXPECT_EQ(plant->sense(t), k % 2 == 0) << t;
    plant->command(t, weight());
    EXPECT_EQ(plant->truth_time(), due_last) << t;
    EXPECT_DOUBLE_EQ(plant->step_end(t, 1.0), t + 0.001);
    if (k % 2 == 0) {
      EXPECT_EQ(plant->sample_end(t + 0.001), 0.001 * (k + 2)) << t;
    }
    EXPECT_EQ(plant->step(t, t + 0.001), "");
    EXPECT_EQ(plant->body_sample().has_value(), k % 2 == 0) << t;
  }
}

// The planner's wrenches are along level axes; a sole that tilts must not turn them with it.
TEST_F(LeggedPlants, AWholeBodyTurnsWrenchesIntoSolesThatTilt) {
  Push push;
  push.start = 0.02;
  push.duration = 0.1;
  push.impulse = 20.0;  // N s: it falls
  push.link = "trunk";
  const auto plant = whole_body({push});
  Vec<double, 12> wanted = weight();
  wanted.head<6>() << 12.0, -7.0, robot.mass * standard_gravity, 1.0, -2.0, 0.5;
  double tilt = 0.0;
  for (int k = 0; k < 1000; ++k) {
    const double t = 0.001 * k;
    const bool due = plant->sense(t);
    const Mat<double, 3, 3> sole = plant->sole(Side::left).rotation;
    const double yaw = std::atan2(sole(1, 0), sole(0, 0));
    const Mat<double, 3, 3> level = flat_sole({0, 0, 0}, yaw).rotation;
    plant->command(t, wanted);
    ASSERT_EQ(plant->step(t, t + 0.001), "");
    if (!due) continue;
    tilt = std::max(tilt, std::acos(std::min(1.0, sole(2, 2))));
    const Vec<double, 6> planned = plant->body_sample()->planned.head<6>();
    for (const int part : {0, 3})
      ASSERT_LT((sole * planned.segment<3>(part) - level * wanted.segment<3>(part)).norm(), 1e-9)
          << t;
    const Vec<double, 3> expected = level * plant->applied().head<3>();
    ASSERT_LT((expected - plant->contact_force()).norm(), 1e-9) << t;
  }
  EXPECT_GT(tilt, 0.05);  // rad
}

// No foot may be where the ground's step is at the start.
TEST_F(LeggedPlants, AStepOfTheGroundUnderAFootIsRefused) {
  const double beside = std::abs(start().scene.swing.position[1]);
  PlantSettings settings;
  settings.choice = PlantChoice::dart;
  settings.ground_step = 0.03;
  settings.ground_edge = beside;
  const auto make = [&] { make_whole_body_legged_plant(start(), {urdf, {}, {}}, settings); };
  EXPECT_THROW(make(), InputError);
  settings.ground_edge = beside + 0.2;
  EXPECT_NO_THROW(make());
  settings.ground_edge = beside;
  settings.ground_step = -0.03;  // below the foot in the air
  EXPECT_NO_THROW(make());
}

// On two feet by the lever, on one all of it.
TEST(Scene, WhatFeetBearOfABodyThatStandsStill) {
  Scene scene;
  scene.swing = flat_sole({0.0, -0.2, 0.0});
  const double weight = 30.0 * standard_gravity;
  const Vec<double, 3> com(0.01, -0.05, 0.5);
  EXPECT_EQ(scene.standing_wrenches(30.0, com)[2], weight);
  scene.two_feet = true;
  const Vec<double, 12> both = scene.standing_wrenches(30.0, com);
  EXPECT_NEAR(both[2], 0.75 * weight, 1e-9);
  EXPECT_NEAR(both[8], 0.25 * weight, 1e-9);
  scene.stand_on(Side::right);
  EXPECT_LT((scene.standing_wrenches(30.0, com) - both).norm(), 1e-9);
}

}  // namespace
}  // namespace saltus::walking
