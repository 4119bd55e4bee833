// Several threads read robot descriptions at the same time, as docs/promise.md promises.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus {
namespace {

constexpr const char* urdf = R"(<?xml version="1.0"?>
<robot name="one leg">
  <link name="body"><inertial><origin xyz="0 0 0.2"/><mass value="3"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="leg"><inertial><origin xyz="0 0 -0.25"/><mass value="1"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="knee" type="revolute"><parent link="body"/><child link="leg"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="30" velocity="1"/></joint>
</robot>)";

constexpr const char* description = R"(
name: Robo
source: made up
mass: 30
soles: {left: ls, right: rs}
contact_plane_offset: -0.01
left_foot: {x: [-0.05, 0.1], y: [-0.03, 0.04]}
right_foot: {x: [-0.05, 0.1], y: [-0.04, 0.03]}
postures:
  stand: {stance: both, com: [0, -0.07, 0.5], other_foot: [0, -0.14, 0], joints: {knee: -0.5}}
)";

TEST(RobotThreads, FourThreadsReadAModelAndADescription) {
  const robots::UrdfModel model = robots::UrdfModel::parse(urdf, "robot.urdf");
  const robots::RobotDescription robot = robots::parse_robot_description(description, "robot.yaml");
  const auto com_of = [&](int k) {
    return model.centre_of_mass("body", {{"knee", 0.01 * (k % 50)}});
  };
  std::vector<Vec<double, 3>> expected;
  for (int k = 0; k < 50; ++k) expected.push_back(com_of(k));
  std::atomic<int> others = 0;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      const robots::UrdfModel own_model = model;
      const robots::RobotDescription own = robot;
      for (int k = 0; k < 200; ++k) {
        others += com_of(k) == expected[k % 50] ? 0 : 1;
        others += own_model.link_poses({{"knee", 0.3}}).size() == 2u ? 0 : 1;
        others += robot.posture("stand").com == own.default_posture().com ? 0 : 1;
      }
    });
  threads.clear();
  EXPECT_EQ(others, 0);
}

TEST(RobotDescription, HasNoDefaultWithoutPostures) {
  EXPECT_THROW((void)robots::RobotDescription().default_posture(), DefinitionError);
}

}  // namespace
}  // namespace saltus
