// What the closed loop drives, asked directly: a few steps of each plant, no controller above it.
#include "saltus/robots/walking/legged_plant.hpp"

#include <gtest/gtest.h>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "tests/app/support.hpp"
#include "tests/problems/synthetic_biped.hpp"

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
  std::unique_ptr<LeggedPlant> whole_body() const {
    PlantSettings settings;
    settings.choice = PlantChoice::dart;
    return make_whole_body_legged_plant(start(), {urdf, {}, {}}, settings);
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
    EXPECT_EQ(plant->step(t, t + 0.001), "");
    EXPECT_EQ(plant->body_sample().has_value(), k % 2 == 0) << t;
  }
}

}  // namespace
}  // namespace saltus::walking
