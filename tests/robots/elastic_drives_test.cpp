// Elastic drives with backlash: the law of motion in both engines, and invalid figures.
#include "saltus/robots/whole_body/elastic_drives.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "saltus/robots/simulation/simulated_robot.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"

namespace saltus::robots {
namespace {

using walking::PlantSettings;
using walking::SimulatedRobot;

constexpr double rotor = 0.1, link = 0.05, foot = 0.003;  // kg m^2
constexpr double motor_torque = 1.0;                      // Nm

JointDrive spring(double stiffness, double backlash = 0.0) {
  JointDrive drive;
  drive.rotor_inertia = rotor;
  drive.stiffness = stiffness;
  drive.backlash = backlash;
  return drive;
}

// A joint on a base that is too heavy to turn. Both fall freely, so no torque of gravity acts.
FloatingRobot one_joint(const JointDrive& drive, double link_inertia = link) {
  FloatingRobot robot;
  robot.name = "joint";
  robot.bodies.resize(2);
  FloatingRobot::Body& base = robot.bodies[0];
  base.name = "base";
  base.mass = 1e6;
  base.inertia.diagonal().setConstant(1e6);
  FloatingRobot::Body& moved = robot.bodies[1];
  moved.name = "link";
  moved.parent = 0;
  moved.joint = "knee";
  moved.mass = 1.0;
  moved.inertia.diagonal().setConstant(link_inertia);
  moved.drive = drive;
  robot.total_mass = base.mass + moved.mass;
  return robot;
}

WholeBodyState high_above_the_ground() {
  WholeBodyState state;
  state.base.setIdentity();
  state.base.translation()[2] = 100.0;
  state.base_twist.setZero();
  state.q = state.dq = VectorXd::Zero(1);
  return state;
}

VectorXd one(double value) { return VectorXd::Constant(1, value); }

class ElasticDrivesIn : public ::testing::TestWithParam<PlantSettings::Choice> {
 protected:
  void SetUp() override {
    if (is_mujoco() && !has_mujoco()) GTEST_SKIP() << "built without MuJoCo";
  }
  bool is_mujoco() const { return GetParam() == PlantSettings::Choice::mujoco; }
  SimulatedRobot simulate(const FloatingRobot& body, double step) const {
    PlantSettings settings;
    settings.engine.step = step;
    SimulatedRobot robot(is_mujoco() ? make_mujoco_plant(body, settings.engine)
                                     : make_dart_plant(body, settings.engine),
                         body, settings, step);
    robot.reset(high_above_the_ground());
    return robot;
  }
};

INSTANTIATE_TEST_SUITE_P(Engines, ElasticDrivesIn,
                         ::testing::Values(PlantSettings::Choice::dart,
                                           PlantSettings::Choice::mujoco),
                         [](const auto& engine) {
                           return engine.param == PlantSettings::Choice::dart ? "Dart" : "Mujoco";
                         });

// Two masses on a spring have the frequency sqrt(k (1 / I + 1 / J)). The spring is loaded at first,
// so the acceleration of the link oscillates about that of a rigid drive.
TEST_P(ElasticDrivesIn, OscillateWithTheNaturalFrequency) {
  constexpr double stiffness = 400.0, step = 1e-4;
  SimulatedRobot robot = simulate(one_joint(spring(stiffness)), step);
  robot.write({one(motor_torque)});
  const double mean = motor_torque / (rotor + link);
  double before = 0.0, speed = 0.0;
  std::vector<double> rising;  // times at which the acceleration passes its mean upwards
  for (int k = 1; k <= 5000; ++k) {
    robot.wait();
    const double now = robot.engine().state().dq[0];
    const double acceleration = (now - speed) / step;
    if (k == 1) {
      EXPECT_NEAR(acceleration, motor_torque / link, 0.01 * motor_torque / link);
    } else if (before < mean && acceleration >= mean) {
      rising.push_back((k - (acceleration - mean) / (acceleration - before)) * step);
    }
    before = acceleration;
    speed = now;
  }
  ASSERT_GE(rising.size(), 8u);
  const double frequency =
      2.0 * M_PI * static_cast<double>(rising.size() - 1) / (rising.back() - rising.front());
  // The relative error of the frequency is of second order in the step.
  const double expected = std::sqrt(stiffness * (1.0 / rotor + 1.0 / link));
  EXPECT_NEAR(frequency, expected, std::pow(step * expected, 2) * expected);
}

// The oscillation of an explicit method grows for steps above 1.1 ms, 0.11 ms and 1.1 us.
TEST_P(ElasticDrivesIn, AreStableAndRigidIfStiff) {
  constexpr double step = 1e-3, duration = 0.2;
  const double expected = motor_torque / (rotor + foot) * duration;
  for (const double stiffness : {1e4, 1e6, 1e10}) {
    SimulatedRobot robot = simulate(one_joint(spring(stiffness), foot), step);
    robot.write({one(motor_torque)});
    for (int k = 0; k < std::lround(duration / step); ++k) robot.wait();
    EXPECT_NEAR(robot.engine().state().dq[0], expected, 1e-3 * expected) << stiffness;
  }
}

// When the motor reverses, the rotor first crosses the play. Meanwhile the link moves freely.
TEST_P(ElasticDrivesIn, LetTheJointMoveFreelyWithinThePlay) {
  constexpr double step = 2e-4, play = 0.01;
  SimulatedRobot robot = simulate(one_joint(spring(1e6, play)), step);
  robot.write({one(motor_torque)});
  for (int k = 0; k < 100; ++k) robot.wait();
  robot.write({one(-motor_torque)});
  int free = 0;
  for (double speed = robot.engine().state().dq[0]; free < 1000; ++free) {
    robot.wait();
    const double now = robot.engine().state().dq[0];
    if (free > 3 && std::abs(now - speed) > 1e-6) break;  // the spring relaxes in three steps
    speed = now;
  }
  const double crossing = std::sqrt(2.0 * play * rotor / motor_torque);
  EXPECT_NEAR(free * step, crossing, 0.05 * crossing);
}

// The inertia of the joint within the play is that of the link alone.
TEST_P(ElasticDrivesIn, DoNotLoadTheJointWithinThePlay) {
  constexpr double step = 1e-3, play = 0.01, force = 1.0, arm = 0.1, duration = 0.05;
  SimulatedRobot robot = simulate(one_joint(spring(1e6, play)), step);
  Pulse push;
  push.impulse = force * duration;
  push.direction = Vec<double, 3>::UnitZ();
  push.start = 0.0;
  push.duration = duration;
  FloatingRobot::Frame point;
  point.body = 1;
  point.pose.translation()[1] = arm;
  robot.push_by({&push, 1}, point);
  robot.write({one(0.0)});
  for (int k = 0; k < std::lround(duration / step); ++k) robot.wait();
  const double expected = force * arm / link * duration;
  ASSERT_LT(robot.engine().state().q[0], 0.5 * play);
  EXPECT_NEAR(robot.engine().state().dq[0], expected, 1e-3 * expected);
}

// Friction holds the rotor, and a load turns the joint to the end of the play.
TEST(ElasticDrives, RestAtTheEndOfThePlay) {
  constexpr double step = 1e-3, stiffness = 1e4, load = 1.0, damping = 5.0;
  const auto rest_angle = [](double play) {
    JointDrive drive = spring(stiffness, play);
    drive.dry_friction = 2.0 * load;
    ElasticDrives drives(one_joint(drive), step);
    JointFriction friction(one_joint(drive), step);
    double q = 0.0, dq = 0.0;
    for (int k = 0; k < 2000; ++k) {
      const VectorXd motor = -friction.step(drives.rotor_speeds(one(dq)));
      const double torque = drives.begin_step(one(q), one(dq), motor)[0];
      dq += step * (torque + load - damping * dq) / (link + drives.inertias()[0]);
      q += step * dq;
      drives.end_step(one(dq));
    }
    EXPECT_LT(std::abs(dq), 1e-9);
    return q;
  };
  EXPECT_GT(rest_angle(0.0), load / stiffness);
  EXPECT_NEAR(rest_angle(0.004) - rest_angle(0.0), 0.002, 1e-9);
}

TEST(ElasticDrives, DoNotAllocate) {
  ElasticDrives drives(one_joint(spring(1e4, 1e-3)), 1e-3);
  const VectorXd q = one(0.0), dq = one(0.1), torque = one(1.0);
  const testing::AllocationCount count;
  for (int k = 0; k < 10; ++k) {
    drives.rotor_speeds(dq);
    drives.begin_step(q, dq, torque);
    drives.end_step(dq);
  }
  EXPECT_EQ(count.made(), 0);
}

TEST(ElasticDrives, RejectInvalidFigures) {
  const auto expect_refusal = [](JointDrive drive, const char* part) {
    expect_error<DefinitionError>([&] { ElasticDrives(one_joint(drive), 1e-3); },
                                  {"joint \"knee\"", part});
  };
  expect_refusal(spring(0.0), "stiffness 0");
  expect_refusal(spring(NAN), "stiffness nan");
  expect_refusal(spring(1e4, -1e-3), "backlash of -0.001");
  expect_refusal(spring(infinity, 1e-3), "has backlash but no spring; set its stiffness");
  JointDrive drive = spring(1e4);
  drive.rotor_inertia = 0.0;
  expect_refusal(drive, "has a spring but no rotor inertia; set its rotor_inertia");
}

TEST(DriveFactors, ScaleElasticityAndBacklash) {
  const FloatingRobot robot = one_joint(spring(1e4, 1e-3));
  const auto with = [&](const DriveFactors& factors) {
    return with_drives_scaled(robot, factors).bodies[1].drive;
  };
  EXPECT_EQ(with({.rotor_inertia = 1.0}).stiffness, infinity);
  EXPECT_EQ(with({.rotor_inertia = 1.0}).backlash, 0.0);
  const JointDrive soft = with({.rotor_inertia = 1.0, .elasticity = 2.0, .backlash = 3.0});
  EXPECT_EQ(soft.stiffness, 5e3);
  EXPECT_EQ(soft.backlash, 3e-3);
  const auto refuse = [](const JointDrive& drive, const DriveFactors& factors, const char* part) {
    expect_error<InputError>([&] { with_drives_scaled(one_joint(drive), factors); }, {part});
  };
  refuse(spring(infinity), {.rotor_inertia = 1.0, .elasticity = 1.0}, "no joint has a stiffness");
  refuse(spring(1e4), {.rotor_inertia = 1.0, .elasticity = 1.0, .backlash = 1.0},
         "no joint has a backlash");
}

}  // namespace
}  // namespace saltus::robots
