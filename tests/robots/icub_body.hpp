// iCub as a FloatingRobot, for tests. Needs the URDF file named by SALTUS_ICUB_URDF.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>

#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus {

class IcubBody : public testing::Test {
 protected:
  void SetUp() override {
    urdf_path = std::getenv("SALTUS_ICUB_URDF");
    if (urdf_path == nullptr)
      GTEST_SKIP() << "SALTUS_ICUB_URDF does not name iCubGazeboV2_5's URDF";
    urdf = std::make_unique<robots::UrdfModel>(robots::UrdfModel::read(urdf_path));
    description = icub(urdf_path);
    robot = robots::with_drives_scaled(robots::floating_robot(*urdf, description), {});
    start = robots::standing_state(robot, *urdf, description, description.default_posture());
  }

  std::unique_ptr<robots::WholeBodyController> standing_controller() const {
    robots::ContactCone::Options left, right;
    left.foot = description.left_foot;
    right.foot = description.right_foot;
    return robots::make_inverse_dynamics_controller(robot, left, right);
  }
  /// The robot at rest on the left foot.
  robots::WholeBodyController::Tasks tasks_on_the_left_foot() const {
    robots::WholeBodyController::Tasks tasks;
    tasks.right_stands = false;
    tasks.posture = start.q;
    tasks.wrenches[2] = robot.total_mass * robots::standard_gravity;
    return tasks;
  }

  const char* urdf_path = nullptr;
  std::unique_ptr<robots::UrdfModel> urdf;
  robots::RobotDescription description;
  robots::FloatingRobot robot;
  robots::WholeBodyState start;  ///< at rest in the initial posture
};

}  // namespace saltus
