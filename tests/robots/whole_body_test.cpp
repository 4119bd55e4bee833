// The whole body of iCub, reduced to its motors, controlled and simulated by DART. Needs the URDF
// file named by SALTUS_ICUB_URDF.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/swing_foot.hpp"
#include "saltus/robots/whole_body/swing_orientation.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"
#include "tests/robots/balance_on_the_left_foot.hpp"
#include "tests/robots/icub_body.hpp"
#include "tests/support/dense_algebra.hpp"

namespace saltus {
namespace {

using WholeBody = IcubBody;

TEST_F(WholeBody, HasItsMotorsAndTotalMass) {
  EXPECT_EQ(robot.joints(), 23);
  double mass = 0.0;
  for (const robots::FloatingRobot::Body& b : robot.bodies) mass += b.mass;
  EXPECT_NEAR(mass, 33.0617, 1e-3);
  EXPECT_NEAR(mass, urdf->total_mass(), 1e-12);
}

// The order of the configuration file has no effect.
TEST_F(WholeBody, OrdersJointsByTheTreeOfTheUrdf) {
  std::vector<std::string> joints;  // those with motors
  for (const std::string& joint : urdf->moving_joint_names()) {
    const auto has_name = [&](const auto& driven) { return driven.name == joint; };
    if (std::ranges::any_of(description.joints, has_name)) joints.push_back(joint);
  }
  EXPECT_NE(joints.front(), description.joints.front().name);
  ASSERT_EQ(static_cast<int>(joints.size()), robot.joints());
  std::ranges::reverse(description.joints);
  const robots::FloatingRobot again = robots::floating_robot(*urdf, description);
  for (int i = 0; i < robot.joints(); ++i) {
    const std::string& joint = joints[static_cast<std::size_t>(i)];
    EXPECT_EQ(robot.joint_index(joint), i) << joint;
    EXPECT_EQ(again.joint_index(joint), i) << joint;
  }
}

TEST_F(WholeBody, HasVisualShapes) {
  std::size_t looks = 0, links = 0;
  for (const robots::FloatingRobot::Body& b : robot.bodies)
    for (const robots::FloatingRobot::Look& look : b.looks) {
      EXPECT_FALSE(look.visuals.empty()) << look.link;
      ++looks;
    }
  for (const robots::UrdfModel::Link& link : urdf->links()) links += link.visuals.empty() ? 0 : 1;
  EXPECT_EQ(looks, links);
  EXPECT_GT(links, 20u);
}

TEST_F(WholeBody, ModelAgreesWithTheUrdf) {
  const auto model = robots::make_dart_dynamics(robot);
  model->update(start);
  // Left contact frame at the origin: the CoM of the description, computed from the URDF.
  EXPECT_LT((model->com() - description.default_posture().com).norm(), 1e-9);
  EXPECT_LT((model->sole(robots::Side::left).pose.matrix() - MatrixXd::Identity(4, 4)).norm(),
            1e-9);
  EXPECT_LT((model->sole(robots::Side::right).pose.translation() -
             description.default_posture().other_foot)
                .norm(),
            1e-9);
  // The base carries the weight, in base axes; the linear block of M is the mass.
  const Vec<double, 3> weight = model->bias().segment<3>(3);
  EXPECT_NEAR(weight.norm(), urdf->total_mass() * robots::standard_gravity, 1e-9);
  EXPECT_NEAR(model->mass_matrix()(3, 3), urdf->total_mass(), 1e-9);
}

// Compares twists and drifts with differences along a motion.
TEST_F(WholeBody, SolesMoveAccordingToTheirJacobians) {
  const auto model = robots::make_dart_dynamics(robot);
  robots::WholeBodyState state = start;
  for (int i = 0; i < robot.joints(); ++i) state.dq[i] = 0.3 * std::sin(1.0 + i);
  const double h = 1e-6;
  robots::WholeBodyState before = state, after = state;
  before.q -= h * state.dq;  // the base rests
  after.q += h * state.dq;
  model->update(before);
  const robots::DynamicsModel::SoleMotion a = model->sole(robots::Side::right);
  const Vec<double, 3> com_a = model->com();
  model->update(after);
  const robots::DynamicsModel::SoleMotion b = model->sole(robots::Side::right);
  const Vec<double, 3> com_b = model->com();
  model->update(state);
  const robots::DynamicsModel::SoleMotion& sole = model->sole(robots::Side::right);
  constexpr double tolerance = 1e-7;  // h^2 and rounding / h
  EXPECT_LT(
      ((b.pose.translation() - a.pose.translation()) / (2.0 * h) - sole.twist.tail<3>()).norm(),
      tolerance);
  EXPECT_LT(((com_b - com_a) / (2.0 * h) - model->com_velocity()).norm(), tolerance);
  EXPECT_LT(((b.twist - a.twist) / (2.0 * h) - sole.drift).norm(), tolerance);
}

TEST_F(WholeBody, AnyLinkOfTheUrdfHasAFrame) {
  for (const char* link : {"chest", "head", "l_hand", "r_foot", "root_link"}) {
    const robots::FloatingRobot::Frame frame = robots::link_frame(robot, *urdf, link);
    const std::string body = robot.bodies[frame.body].name;
    const Eigen::Isometry3d expected = urdf->link_pose(link, body, {});  // joints do not matter
    EXPECT_LT((frame.pose.matrix() - expected.matrix()).norm(), 1e-12) << link << " in " << body;
  }
  EXPECT_THROW(robots::link_frame(robot, *urdf, "no_such_link"), InputError);
}

// In the air, the force changes the linear and the angular momentum exactly.
TEST_F(WholeBody, PushActsAtItsPoint) {
  const auto model = robots::make_dart_dynamics(robot);
  const auto plant = robots::make_dart_plant(robot, {});
  start.base.translation()[2] += 2.0;
  plant->reset(start);
  model->update(start);
  robots::FloatingRobot::Frame frame = robots::link_frame(robot, *urdf, "head");
  frame.pose.translate(Vec<double, 3>(0.1, 0.05, -0.02));
  const robots::FloatingRobot::Frame body =
      robots::link_frame(robot, *urdf, robot.bodies[frame.body].name);
  ASSERT_EQ(body.body, frame.body);
  // Pose of that body from the base through the joints of the posture.
  const Eigen::Isometry3d pose =
      start.base * urdf->link_pose(robot.bodies[frame.body].name, robot.bodies[0].name,
                                   description.default_posture().joints);
  const Vec<double, 3> force(30.0, -50.0, 20.0),
      arm = pose * frame.pose.translation() - model->com();
  plant->push(frame.body, force, frame.pose.translation());
  plant->step();
  model->update(plant->state());
  const double dt = 1e-3;  // s, one step
  const Vec<double, 3> weight(0.0, 0.0, -model->mass() * robots::standard_gravity);
  // One step of an explicit integrator: the error is of second order.
  constexpr double second_order = 1e-4;
  EXPECT_LT((model->mass() * model->com_velocity() - dt * (force + weight)).norm(), second_order);
  EXPECT_LT((model->angular_momentum() - dt * arm.cross(force)).norm(), second_order);
  EXPECT_GT(dt * arm.cross(force).norm(), 100.0 * second_order);
}

// DART's forward dynamics, which forms no mass matrix, in free fall: one step gives dnu/dt.
TEST_F(WholeBody, EquationsOfMotionAgreeWithTheEngine) {
  robot = robots::with_drives_scaled(robots::floating_robot(*urdf, description),
                                     {.rotor_inertia = 1.0});
  const auto model = robots::make_dart_dynamics(robot);
  robots::DartOptions options;
  options.step = 1e-6;
  const auto plant = robots::make_dart_plant(robot, options);
  const auto velocity = [](const robots::WholeBodyState& s) {
    VectorXd nu(6 + s.dq.size());
    nu << s.base.linear().transpose() * s.base_twist.head<3>(),
        s.base.linear().transpose() * s.base_twist.tail<3>(), s.dq;
    return nu;
  };
  for (const int trial : {0, 1, 2, 3}) {
    robots::WholeBodyState state = start;
    state.base.translation()[2] += 1.0;
    state.base.rotate(Eigen::AngleAxisd(0.4 * trial, Vec<double, 3>(1.0, 2.0, -1.0).normalized()));
    VectorXd tau(robot.joints());
    for (int i = 0; i < robot.joints(); ++i) {
      state.q[i] += 0.1 * std::sin(2.0 * i + trial) * (state.q[i] > 0.2 ? 1.0 : 0.0);
      state.dq[i] = 0.3 * std::sin(1.0 + 3.0 * i + trial);
      tau[i] = 2.0 * std::cos(5.0 * i - trial);
    }
    state.base_twist << 0.3, -0.4, 0.2, 0.1, 0.5, -0.3;
    model->update(state);
    plant->reset(state);
    plant->set_torques(tau);
    const Vec<double, 3> force(30.0, -20.0 * trial, 10.0), point(0.1, 0.05, -0.1);
    plant->push(0, force, point);
    plant->step();
    const VectorXd rate = (velocity(plant->state()) - velocity(state)) / options.step;
    VectorXd forces = -model->bias();
    forces.tail(robot.joints()) += tau;
    const Vec<double, 3> own = state.base.linear().transpose() * force;
    forces.head<3>() += point.cross(own);
    forces.segment<3>(3) += own;
    const VectorXd expected = testing::solver_of(model->mass_matrix())(forces);
    // The step is of first order, 70 rad/s^2 per s; accelerations are tens.
    ASSERT_GT(expected.cwiseAbs().maxCoeff(), 10.0);
    EXPECT_LT((rate - expected).cwiseAbs().maxCoeff(), 2e-4) << trial;
  }
}

// A landing: M (nu_1 - nu_0) is the impulse of the contact and of all other forces. Without the
// rotors in the impulses of the engine it would differ by half.
TEST_F(WholeBody, ImpulsesOfALandingActOnTheRotors) {
  robot = robots::with_drives_scaled(robots::floating_robot(*urdf, description),
                                     {.rotor_inertia = 1.0});
  const auto model = robots::make_dart_dynamics(robot);
  robots::DartOptions options;
  options.step = 1e-5;
  const auto plant = robots::make_dart_plant(robot, options);
  start.base.translation()[2] -= 1e-5;
  start.base_twist[5] = -0.3;
  model->update(start);
  plant->reset(start);
  plant->step();
  const robots::WholeBodyEstimate::Contact& contact = plant->contact(robots::Side::left);
  ASSERT_TRUE(contact.touches);
  const robots::WholeBodyState& after = plant->state();
  VectorXd change(6 + robot.joints());
  change << start.base.linear().transpose() * (after.base_twist - start.base_twist).head<3>(),
      start.base.linear().transpose() * (after.base_twist - start.base_twist).tail<3>(),
      after.dq - start.dq;
  Vec<double, 6> wrench;
  wrench << contact.wrench.tail<3>(), contact.wrench.head<3>();
  const VectorXd impulse =
      options.step *
      (model->sole(robots::Side::left).jacobian.transpose() * wrench - model->bias());
  const VectorXd momentum = model->mass_matrix() * change;
  EXPECT_GT(impulse.norm(), 1.0);
  EXPECT_LT((momentum - impulse).norm(), 1e-3 * impulse.norm());
}

TEST_F(WholeBody, StandsOnOneFootAndReactsToAPush) {
  const auto model = robots::make_dart_dynamics(robot);
  const auto plant = robots::make_dart_plant(robot, {});
  plant->reset(start);
  model->update(plant->state());
  const auto controller = standing_controller();
  const robots::WholeBodyController::Tasks tasks = tasks_on_the_left_foot();
  const auto check = [this](const robots::WholeBodyController::Command& command, double t) {
    ASSERT_LT(command.stance_slip, 1e-6) << t;
    for (int i = 0; i < robot.joints(); ++i)
      ASSERT_LE(std::abs(command.torques[i]), robot.bodies[i + 1].effort) << t;
  };
  balance_on_the_left_foot(robot, *model, *plant, *controller, tasks,
                           {.impulse = 4.0, .start = 0.5, .end = 3.0}, check);
  EXPECT_NEAR(plant->contact(robots::Side::left).wrench[2],
              model->mass() * robots::standard_gravity, 2.0);
}

TEST(SwingFoot, RisesAndLandsOnTimeAtRest) {
  robots::SwingFoot swing;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << 0.0, -0.13, 0.005;
  swing.hold(pose);
  swing.start(1.0, 1.6);
  swing.aim(1.6, {0.0, -0.25, 0.0});
  double highest = 0.0;
  Vec<double, 3> last = swing.reference();  // at most 2 ms before the landing
  double speed = 0.0;
  for (int k = 1; k < 300; ++k) {
    swing.advance(1.0 + 0.002 * k);
    highest = std::max(highest, swing.reference()[2]);
    speed = (swing.reference() - last).norm() / 0.002;
    last = swing.reference();
  }
  EXPECT_NEAR(highest, 0.03, 0.002);
  EXPECT_LT((last - Vec<double, 3>(0.0, -0.25, 0.0)).norm(), 1e-4);
  EXPECT_LT(speed, 0.02);
}

Mat<double, 3, 3> turned_by(double yaw) {
  return robots::flat_sole(Vec<double, 3>::Zero(), yaw).rotation;
}

TEST(SwingOrientation, TurnsTheShorterWayAndRestsAtTheLanding) {
  for (const double from : {0.1, 3.1}) {
    robots::SwingOrientation swing;
    swing.hold(turned_by(from));
    EXPECT_FALSE(swing.is_aimed());
    const double to = std::remainder(from + 0.2, 2.0 * std::numbers::pi);
    double last = 0.0, fastest = 0.0, speed = 0.0;
    for (int k = 0; k < 199; ++k) {
      const double t = 1.0 + 0.002 * k;
      swing.aim(t, 1.4, Vec<double, 3>::UnitZ(), to);
      swing.advance(t);
      const Mat<double, 3, 3> turn = swing.reference() * turned_by(from).transpose();
      const double yaw = std::atan2(turn(1, 0), turn(0, 0));
      speed = (yaw - last) / 0.002;
      fastest = std::max(fastest, speed);
      EXPECT_GE(speed, -1e-9);
      last = yaw;
    }
    EXPECT_TRUE(swing.is_aimed());
    EXPECT_NEAR(last, 0.2, 1e-4);
    EXPECT_LT(speed, 0.02);
    EXPECT_NEAR(fastest, 15.0 / 8.0 * 0.2 / 0.4, 0.02);  // peak of the minimum-jerk turn
  }
}

// Without a heading the foot keeps its yaw. The sole becomes parallel to the ground.
TEST(SwingOrientation, BecomesParallelToTheGround) {
  robots::SwingOrientation swing;
  swing.hold(turned_by(0.7));
  const Vec<double, 3> normal = Vec<double, 3>(-0.08, 0.03, 1.0).normalized();
  for (int k = 0; k < 250; ++k) {
    swing.aim(0.002 * k, 0.4, normal);
    swing.advance(0.002 * k);
  }
  const Mat<double, 3, 3> there = swing.reference();
  EXPECT_LT((there.col(2) - normal).norm(), 1e-6);
  EXPECT_NEAR(std::atan2(there(1, 0), there(0, 0)), 0.7, 0.005);  // second order in the tilt
  swing.hold(there);
  EXPECT_LT((swing.reference() - there).norm(), 1e-12);
}

// A foot that is behind its reference turns towards it, and a tilted one becomes level.
TEST(SwingOrientation, AcceleratesTowardsTheReference) {
  const Vec<double, 3> up = Vec<double, 3>::UnitZ(), ahead = Vec<double, 3>::UnitX();
  robots::SwingOrientation swing;
  swing.hold(Mat<double, 3, 3>::Identity());
  robots::DynamicsModel::SoleMotion sole;
  sole.twist.setZero();
  sole.pose.setIdentity();
  EXPECT_LT(swing.acceleration(sole).norm(), 1e-9);
  swing.aim(0.0, 0.0, up, 0.05);  // the landing is due
  swing.advance(0.002);
  EXPECT_LT((swing.acceleration(sole) - 400.0 * 0.05 * up).norm(), 1e-6);
  sole.pose.linear() =
      (Eigen::AngleAxisd(0.05, up) * Eigen::AngleAxisd(0.1, ahead)).toRotationMatrix();
  const Vec<double, 3> about = turned_by(0.05) * ahead;
  EXPECT_LT((swing.acceleration(sole) + 400.0 * 0.1 * about).norm(), 1e-6);
}

// On the way down, the foot does not rise again if the landing is slightly delayed.
TEST(SwingFoot, TouchesTheGroundWithTheGivenSpeed) {
  robots::SwingOptions options;
  options.touch_speed = 0.1;
  robots::SwingFoot swing(options);
  swing.hold(Eigen::Isometry3d::Identity());
  swing.start(0.0, 0.5);
  swing.aim(0.5, {0.1, 0.0, 0.0});
  constexpr double dt = 1e-3;
  for (int k = 1; k < 500; ++k) {
    const double before = swing.reference()[2], t = k * dt;
    swing.advance(t);
    if (t < 0.46) continue;  // the last 5 mm
    EXPECT_NEAR((before - swing.reference()[2]) / dt, options.touch_speed, 2e-3) << t;
    EXPECT_NEAR(swing.reference()[2], options.touch_speed * (0.5 - t), 5e-4) << t;
    if (t < 0.475) continue;  // half of them
    EXPECT_NEAR(swing.reference()[0], 0.1, 1e-6) << t;
  }
}

TEST(SwingFoot, DoesNotRiseAgainForALaterLanding) {
  robots::SwingFoot swing;
  swing.hold(Eigen::Isometry3d::Identity());
  swing.start(0.0, 0.4);
  double height = infinity;
  for (int k = 0; k < 250; ++k) {
    swing.aim(k < 106 ? 0.4 : 0.5, {0.1, 0.0, 0.0});
    swing.advance(0.002 * k);
    if (k < 106) continue;
    EXPECT_LE(swing.reference()[2], height) << k;
    height = swing.reference()[2];
  }
  EXPECT_LT(height, 1e-4);
}

// The foot stays above the ground for any late change of the landing time.
TEST(SwingFoot, StaysAboveTheGroundForAMuchLaterLanding) {
  for (const int told : {110, 130, 150, 170, 185, 195, 199})
    for (const double later : {0.02, 0.1, 0.3, 1.0}) {
      robots::SwingFoot swing;
      swing.hold(Eigen::Isometry3d::Identity());
      swing.start(0.0, 0.4);
      double fastest = 0.0, before = 0.0;
      for (int k = 1; 0.002 * k < 0.4 + later - 0.001; ++k) {
        swing.aim(k < told ? 0.4 : 0.4 + later, {0.1, 0.0, 0.0});
        swing.advance(0.002 * k);
        ASSERT_GE(swing.reference()[2], -1e-6) << told << " " << later << " " << k;
        if (k > told) fastest = std::max(fastest, std::abs(swing.reference()[2] - before) / 0.002);
        before = swing.reference()[2];
      }
      EXPECT_LT(swing.reference()[2], 1e-4);
      EXPECT_LT(fastest, 0.3);  // m/s, of a rise of 3 cm in 0.2 s and back
    }
}

// If the remaining time is halved during the swing, the landing is as slow as with an early plan.
TEST(SwingFoot, DescendsSoonerForAnEarlierLanding) {
  const auto fastest_descent = [](double first_landing) {
    robots::SwingFoot swing;
    swing.hold(Eigen::Isometry3d::Identity());
    swing.start(0.0, first_landing);
    double before = 0.0, fastest = 0.0;
    for (int k = 1; k < 150; ++k) {
      swing.aim(k < 20 ? first_landing : 0.3, {0.0, -0.1, 0.0});
      swing.advance(0.002 * k);
      fastest = std::max(fastest, (before - swing.reference()[2]) / 0.002);
      before = swing.reference()[2];
    }
    return fastest;
  };
  EXPECT_LT(fastest_descent(0.4), 1.3 * fastest_descent(0.3));
}

}  // namespace
}  // namespace saltus
