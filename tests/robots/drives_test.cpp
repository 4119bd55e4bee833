// Drives of the joints: limits, friction, commands; and the hold of standing feet.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/robots/whole_body/joint_friction.hpp"
#include "saltus/robots/whole_body/stance_foot.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus::robots {
namespace {

constexpr double step = 1e-3;  // s

// A robot with one joint.
FloatingRobot one_joint(const JointDrive& drive) {
  FloatingRobot robot;
  robot.bodies.resize(2);
  robot.bodies[1].joint = "knee";
  robot.bodies[1].effort = 40.0;
  robot.bodies[1].drive = drive;
  return robot;
}

JointDrive geared() {
  JointDrive drive;
  drive.rotor_inertia = 0.15;
  drive.dry_friction = 2.0;
  drive.breakaway = 1.5;
  drive.viscous_friction = 1.0;
  return drive;
}

VectorXd one(double value) { return VectorXd::Constant(1, value); }

TEST(JointDrive, TorqueFallsLinearlyWithTheSpeed) {
  JointDrive drive;
  EXPECT_EQ(drive.torque_range(40.0, 100.0).upper, 40.0);  // no limit of the speed
  drive.no_load_speed = 8.0;
  EXPECT_EQ(drive.torque_range(40.0, 2.0).upper, 30.0);
  EXPECT_EQ(drive.torque_range(40.0, 2.0).lower, -40.0);  // braking
  EXPECT_EQ(drive.torque_range(40.0, -6.0).lower, -10.0);
  EXPECT_EQ(drive.torque_range(40.0, -6.0).upper, 40.0);
  EXPECT_EQ(drive.torque_range(40.0, 9.0).upper, 0.0);
  drive.stall_torque = 24.0;  // below the effort limit
  EXPECT_EQ(drive.torque_range(40.0, 2.0).upper, 18.0);
  EXPECT_EQ(drive.torque_range(20.0, 2.0).upper, 15.0);
}

TEST(DriveFactors, NeedFiguresOfTheRobot) {
  EXPECT_TRUE(with_drives_scaled(one_joint(geared()), {}).bodies[1].drive.is_ideal());
  EXPECT_EQ(
      with_drives_scaled(one_joint(geared()), {2.0, 0.0, false}).bodies[1].drive.rotor_inertia,
      0.3);
  EXPECT_NO_THROW(with_drives_scaled(one_joint({}), {}));
  EXPECT_THROW(with_drives_scaled(one_joint({}), {.rotor_inertia = 1.0}), InputError);
  EXPECT_THROW(with_drives_scaled(one_joint(geared()), {.torque_speed_line = true}), InputError);
}

// The motor acts on the rotor alone: a joint at rest stays at rest up to the breakaway torque.
TEST(JointFriction, HoldsAJointUpToTheBreakaway) {
  const JointDrive drive = geared();
  const auto motion_under = [&drive](double torque) {
    JointFriction friction(one_joint(drive), step);
    double q = 0.0, dq = 0.0;
    for (int k = 0; k < 3000; ++k) {
      const double applied = torque * std::min(1.0, 1e-3 * k);  // slowly, so that nothing swings
      dq += step * (applied - friction.step(one(dq))[0]) / drive.rotor_inertia;
      q += step * dq;
    }
    return std::pair(q, dq);
  };
  const auto [q, dq] = motion_under(2.9);
  EXPECT_LT(std::abs(q), 1e-3);
  EXPECT_LT(std::abs(dq), 1e-5);
  // Beyond it the joint slides; dry and viscous friction balance the torque.
  EXPECT_NEAR(motion_under(3.1).second, 1.1, 1e-3);
  EXPECT_NEAR(motion_under(-5.0).second, -3.0, 1e-3);
}

TEST(JointFriction, IsZeroForIdealDrives) {
  EXPECT_TRUE(JointFriction(one_joint({}), step).is_zero());
  EXPECT_FALSE(JointFriction(one_joint(geared()), step).is_zero());
}

TEST(JointFriction, RejectsInvalidFigures) {
  const auto rejects = [](JointDrive drive) {
    EXPECT_THROW(JointFriction(one_joint(drive), step), DefinitionError);
  };
  JointDrive drive = geared();
  drive.rotor_inertia = 0.0;
  rejects(drive);
  drive = geared();
  drive.dry_friction = -1.0;
  rejects(drive);
  drive = geared();
  drive.breakaway = 0.5;
  rejects(drive);
  drive = geared();
  drive.viscous_friction = NAN;
  rejects(drive);
}

// The controllers' model of the friction is right: a rotor follows the acceleration.
TEST(DriveController, CompensatesFriction) {
  JointDrive drive = geared();
  drive.breakaway = 1.0;
  const FloatingRobot robot = one_joint(drive);
  JointFriction friction(robot, step);
  DriveController controller(robot, {}, step);
  WholeBodyController::Command command;
  command.torques = one(1.5);
  command.joint_acceleration = one(1.5 / drive.rotor_inertia);
  WholeBodyState state;
  state.q = state.dq = one(0.0);
  controller.start(state.q);
  constexpr int steps = 200;
  for (int k = 0; k < steps; ++k) {
    const double torque = controller.update(command, state).torques[0];
    state.dq[0] += step * (torque - friction.step(state.dq)[0]) / drive.rotor_inertia;
    state.q += step * state.dq;
  }
  // 2 rad/s; without compensation the joint would not move.
  EXPECT_NEAR(state.dq[0], steps * step * command.joint_acceleration[0], 0.1);
}

// Half of the friction is unknown. The springs around the intended motion keep the joint near it.
TEST(DriveController, SpringsCounterUnknownFriction) {
  const FloatingRobot robot = one_joint(geared());
  const auto reached = [&robot](double stiffness) {
    JointFriction friction(robot, step);
    DriveController controller(with_drives_scaled(robot, {1.0, 0.5, false}),
                               {.stiffness = stiffness, .damping = 0.05 * stiffness}, step);
    WholeBodyController::Command command;
    command.torques = one(0.6);
    command.joint_acceleration = one(4.0);
    WholeBodyState state;
    state.q = state.dq = one(0.0);
    controller.start(state.q);
    for (int k = 0; k < 200; ++k) {
      const Robot::Commands& c = controller.update(command, state);
      double torque = c.torques[0];
      if (c.positions.size() > 0)
        torque += c.stiffness[0] * (c.positions[0] - state.q[0]) +
                  c.damping[0] * (c.velocities[0] - state.dq[0]);
      state.dq[0] += step * (torque - friction.step(state.dq)[0]) / 0.15;
      state.q += step * state.dq;
    }
    return state.q[0];
  };
  const double intended = 0.5 * 4.0 * 0.2 * 0.2;
  EXPECT_LT(reached(0.0), 0.1 * intended);
  EXPECT_GT(reached(5.0), 0.5 * intended);
}

TEST(DriveController, RejectsInvalidOptions) {
  const FloatingRobot robot = one_joint({});
  EXPECT_THROW(DriveController(robot, {.stiffness = -1.0}, step), DefinitionError);
  EXPECT_THROW(DriveController(robot, {.damping = NAN}, step), DefinitionError);
  EXPECT_THROW(DriveController(robot, {.follow = 0.0}, step), DefinitionError);
  EXPECT_THROW(DriveController(robot, {}, 0.0), DefinitionError);
  FloatingRobot strong = robot;
  strong.bodies[1].effort = infinity;
  EXPECT_THROW(DriveController(strong, {.stiffness = 1.0}, step), DefinitionError);
}

DynamicsModel::SoleMotion sole_at(double height, double tilt = 0.0) {
  DynamicsModel::SoleMotion sole;
  sole.pose = Eigen::Isometry3d::Identity();
  sole.pose.translation()[2] = height;
  sole.pose.rotate(Eigen::AngleAxisd(tilt, Vec<double, 3>::UnitX()));
  return sole;
}

constexpr double loaded = 200.0, unloaded = 0.0;  // N

TEST(StanceFoot, ReturnsToThePlaceWhereItCarriedLoad) {
  StanceFoot foot({.stiffness = 100.0, .search_speed = 0.0});
  foot.stand(sole_at(0.0).pose);
  foot.advance(step, sole_at(0.004, 0.05), unloaded);
  const Vec<double, 6> back = foot.acceleration(sole_at(0.004, 0.05));
  EXPECT_NEAR(back[5], -100.0 * 0.004, 1e-9);
  EXPECT_NEAR(back[0], -100.0 * 0.05, 1e-9);
}

TEST(StanceFoot, AcceptsTheGroundThatCarriesIt) {
  StanceFoot foot({.stiffness = 100.0, .follow = 0.05});
  foot.stand(sole_at(0.0).pose);
  for (int k = 0; k < 500; ++k) foot.advance(step, sole_at(0.004, 0.05), loaded);
  EXPECT_LT(foot.acceleration(sole_at(0.004, 0.05)).norm(), 1e-3);
}

TEST(StanceFoot, SearchesForTheGroundWithoutLoad) {
  StanceFoot foot({.stiffness = 100.0, .search_speed = 0.1, .search_depth = 0.03});
  foot.stand(sole_at(0.0).pose);
  for (int k = 0; k < 100; ++k) foot.advance(step, sole_at(0.0), unloaded);
  EXPECT_NEAR(foot.acceleration(sole_at(0.0))[5], -100.0 * 0.01, 1e-9);
  for (int k = 0; k < 1000; ++k) foot.advance(step, sole_at(0.0), unloaded);
  EXPECT_NEAR(foot.acceleration(sole_at(0.0))[5], -100.0 * 0.03, 1e-9);
  foot.advance(step, sole_at(0.0), loaded);
  EXPECT_NEAR(foot.acceleration(sole_at(0.0))[5], 0.0, 1e-9);
}

// A slip is accepted beyond the largest error that is corrected.
TEST(StanceFoot, FollowsALargeSlip) {
  StanceFoot foot({.stiffness = 100.0, .search_speed = 0.0, .most_distance = 0.02});
  foot.stand(sole_at(0.0).pose);
  foot.advance(step, sole_at(0.05), unloaded);
  EXPECT_NEAR(foot.acceleration(sole_at(0.05))[5], -100.0 * 0.02, 1e-9);
}

}  // namespace
}  // namespace saltus::robots
