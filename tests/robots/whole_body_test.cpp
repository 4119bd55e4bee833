// Whole-body control of iCub in DART: needs the URDF, whose file SALTUS_ICUB_URDF names.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstdio>
#include "robots/capture_point.hpp"
#include "robots/dart/dart_dynamics.hpp"
#include "robots/dart/dart_plant.hpp"
#include "robots/icub/icub.hpp"
#include "robots/whole_body/whole_body_controller.hpp"

namespace saltus {
namespace {

WholeBodyState standing(const FloatingRobot& robot, const UrdfModel& model, const RobotDescription& d, const StandingPosture& posture) {
  WholeBodyState state;
  Eigen::Isometry3d sole = model.link_pose(d.left_sole, model.links().front().name, posture.joints);
  sole.translate(Vec<double, 3>(0, 0, d.contact_plane_offset));
  state.base = sole.inverse();
  state.q = robot.joint_positions(posture.joints);
  state.dq = VectorXd::Zero(robot.joints());
  return state;
}

TEST(WholeBody, Stands) {
  const char* file = std::getenv("SALTUS_ICUB_URDF");
  if (!file) GTEST_SKIP();
  const UrdfModel urdf = UrdfModel::read(file);
  const RobotDescription d = icub(file);
  const FloatingRobot robot = floating_robot(urdf, d);
  EXPECT_EQ(robot.joints(), 23);
  EXPECT_NEAR(robot.total_mass, 33.06, 0.005);
  auto model = make_dart_dynamics(robot);
  DartOptions options;
  auto plant = make_dart_plant(robot, options);
  WholeBodyState state = standing(robot, urdf, d, d.posture("left_stance"));
  plant->reset(state);
  model->update(plant->state());
  printf("com %g %g %g  mass %g bias %g\n", model->com()[0], model->com()[1], model->com()[2], model->mass(), model->bias()[5]);
  ContactConeOptions cl; cl.foot = d.left_foot; ContactConeOptions cr; cr.foot = d.right_foot;
  WholeBodyController c(robot, cl, cr);
  WholeBodyTasks tasks;
  tasks.right_stands = false;
  tasks.posture = state.q;
  tasks.wrenches[2] = model->mass() * standard_gravity;
  const Vec<double, 3> com0(0.0, 0.0, model->com()[2]);
  const double push = std::getenv("PUSH") ? atof(std::getenv("PUSH")) : 0;
  const int chest = robot.body_index("chest");
  int it = 0, calls = 0;
  const auto right0 = model->sole(Side::right).pose;
  for (int k = 0; k < 4000; ++k) {
    if (k % 2 == 0) {
      model->update(plant->state());
      tasks.force = model->mass() * (50.0 * (com0 - model->com()) - 14.0 * model->com_velocity());
      tasks.torque = -5.0 * model->angular_momentum();
      const auto& s = model->sole(Side::right);
      Eigen::AngleAxisd e(right0.linear() * s.pose.linear().transpose());
      tasks.swing_acceleration.head<3>() = 100 * e.angle() * e.axis() - 20 * s.twist.head<3>();
      tasks.swing_acceleration.tail<3>() = 100 * (right0.translation() - s.pose.translation()) - 20 * s.twist.tail<3>();
      const auto& cmd = c.control(*model, plant->state(), tasks);
      plant->set_torques(cmd.torques);
      it += cmd.iterations; ++calls;
      if (k % 200 == 0)
        printf("%5.3f com %7.4f %7.4f %7.4f H %6.3f fz %7.2f (%d) plan %7.2f it %d st %d slip %.2g lim %.2g tmax %.1f\n", plant->time(), model->com()[0], model->com()[1],
               model->com()[2], model->angular_momentum().norm(), plant->contact(Side::left).wrench[2], plant->contact(Side::left).touches, cmd.wrenches[2], cmd.iterations, (int)cmd.status, cmd.stance_slip, cmd.limit_excess, cmd.torques.cwiseAbs().maxCoeff());
    }
    if (k >= 1000 && k < 1100) plant->push(chest, {0, -push / 0.1, 0}, {0, 0, 0});
    plant->step();
  }
  printf("%s: %d calls, %.1f it\n", plant->name().c_str(), calls, double(it) / calls);
}

}  // namespace
}  // namespace saltus
