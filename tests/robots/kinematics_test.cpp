// Formulas of the kinematics against a second implementation, written with matrices, and against
// differences.
#include "saltus/robots/kinematics/kinematics.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "saltus/model/derivative_check.hpp"
#include "saltus/model/make_function.hpp"
#include "tests/robots/synthetic_biped.hpp"
#include "tests/robots/tree_dynamics.hpp"

namespace saltus {
namespace {

using robots::FloatingRobot;
using robots::Side;

constexpr int n = 14, nq = 6 + n, postures = 100;
using Tree = robots::KinematicTree<n>;
template <class S>
using Robot = robots::Kinematics<n, S>;
template <class S>
using Wrench = robots::WrenchAt<S>;

// The quantities of one posture as a formula of q and dq, with ddq and a wrench as inputs.
constexpr int rows = 30 + nq, inputs = nq + 6;
struct Everything {
  const Tree* tree;
  FloatingRobot::Frame frame;

  template <class S>
  Vec<S, rows> operator()(const S&, const Vec<S, 2 * nq>& x, const Vec<S, inputs>& u) const {
    const Vec<S, nq> q = x.template head<nq>(), dq = x.template tail<nq>(),
                     ddq = u.template head<nq>();
    const Robot<S> robot(*tree, q, dq);
    const std::vector<Wrench<S>> wrenches{
        {frame, u.template segment<3>(nq).eval(), u.template tail<3>().eval()}};
    const Mat<S, 3, 3> axes = robot.rotation(frame);
    Vec<S, rows> y;
    y << robot.position(frame), axes.col(0), axes.col(1), axes.col(2), robot.velocity(frame),
        robot.angular_velocity(frame.body), robot.com(), robot.com_velocity(),
        robot.angular_momentum(), robot.body(3).position,
        robots::inverse_dynamics<S>(*tree, q, dq, ddq, robots::standard_gravity,
                                    std::span<const Wrench<S>>(wrenches));
    return y;
  }
};

class KinematicsOfABiped : public testing::Test {
 protected:
  KinematicsOfABiped() {
    const SyntheticBiped biped;
    const robots::UrdfModel urdf = robots::UrdfModel::parse(biped.urdf(), "biped.urdf");
    robot = robots::floating_robot(
        urdf, robots::describe(urdf, robots::parse_robot_description(
                                         biped.yaml(), "biped.yaml",
                                         robots::RobotDescription::Figures::from_urdf)));
    for (std::size_t i = 1; i < robot.bodies.size(); ++i)
      robot.bodies[i].drive.rotor_inertia = 0.01 * static_cast<double>(i);
  }
  double unit() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random_); }
  VectorXd random(int size) {
    VectorXd v(size);
    for (double& entry : v) entry = unit();
    return v;
  }
  // Posture k. Every fourth one has straight legs, which are singular.
  VectorXd posture(int k) {
    VectorXd q = random(nq);
    q[4] *= 1.4;
    if (k % 4 == 0) q.tail<n>().setZero();
    return q;
  }
  // The same state for DynamicsModel.
  static robots::WholeBodyState state(const Tree& tree, const VectorXd& q, const VectorXd& dq) {
    const Robot<double> at(tree, q, dq);
    robots::WholeBodyState state;
    state.base.translation() = at.body(0).position;
    state.base.linear() = at.body(0).rotation;
    state.base_twist << at.angular_velocity(0), dq.head<3>();
    state.q = q.tail<n>();
    state.dq = dq.tail<n>();
    return state;
  }
  static Vec<double, 3> omega(const Tree& tree, const VectorXd& q, const VectorXd& dq) {
    return Robot<double>(tree, q, dq).angular_velocity(0);
  }

  FloatingRobot robot;
  std::mt19937 random_{7};
};

TEST_F(KinematicsOfABiped, AgreesWithAnotherImplementation) {
  const Tree tree(robot);
  TreeDynamics other(robot);
  for (int k = 0; k < postures; ++k) {
    SCOPED_TRACE(k);
    const VectorXd q = posture(k), dq = random(nq), ddq = random(nq);
    other.update(state(tree, q, dq));
    const Robot<double> at(tree, q, dq);
    EXPECT_LT((at.com() - other.com()).norm(), 1e-12);
    EXPECT_LT((at.com_velocity() - other.com_velocity()).norm(), 1e-12);
    EXPECT_LT((at.angular_momentum() - other.angular_momentum()).norm(), 1e-11);
    for (const Side side : {Side::left, Side::right}) {
      const FloatingRobot::Frame& frame = side == Side::left ? robot.left_sole : robot.right_sole;
      const robots::DynamicsModel::SoleMotion& sole = other.sole(side);
      EXPECT_LT((at.position(frame) - sole.pose.translation()).norm(), 1e-12);
      EXPECT_LT((at.rotation(frame) - sole.pose.linear()).norm(), 1e-12);
      EXPECT_LT((at.angular_velocity(frame.body) - sole.twist.head<3>()).norm(), 1e-12);
      EXPECT_LT((at.velocity(frame) - sole.twist.tail<3>()).norm(), 1e-12);
      EXPECT_LT(
          (robots::frame_jacobian(tree, q, frame) * dq -
           (Vec<double, 6>() << at.velocity(frame), at.angular_velocity(frame.body)).finished())
              .norm(),
          1e-12);
    }
    const Vec<double, 6> momentum = robots::momentum_matrix(tree, q) * dq;
    EXPECT_LT((momentum.head<3>() - robot.total_mass * other.com_velocity()).norm(), 1e-11);
    EXPECT_LT((momentum.tail<3>() - other.angular_momentum()).norm(), 1e-11);

    // Equations of motion. The angular acceleration of the base is a difference.
    constexpr double h = 1e-5;
    const Vec<double, 3> alpha =
        (omega(tree, q + h * dq, dq + h * ddq) - omega(tree, q - h * dq, dq - h * ddq)) / (2.0 * h);
    const Mat<double, 3, 3> R = at.body(0).rotation;
    const Vec<double, 3>& w = at.angular_velocity(0);
    const Vec<double, 3> v = dq.head<3>();
    VectorXd dnu(nq);
    dnu << R.transpose() * alpha, R.transpose() * (ddq.head<3>() - w.cross(v)), ddq.tail<n>();
    Vec<double, 6> force;
    force << 10.0 * random(6);
    const Wrench<double> wrench{robot.right_sole, force.head<3>(), force.tail<3>()};
    VectorXd expected = other.mass_matrix() * dnu + other.bias();
    const MatrixXd& J = other.sole(Side::right).jacobian;
    expected -=
        J.topRows<3>().transpose() * wrench.torque + J.bottomRows<3>().transpose() * wrench.force;
    for (int i = 0; i < n; ++i)
      expected[6 + i] +=
          robot.bodies[static_cast<std::size_t>(i) + 1].drive.rotor_inertia * ddq[6 + i];
    const Vec<double, nq> found = robots::inverse_dynamics<double>(
        tree, q, dq, ddq, robots::standard_gravity, std::span<const Wrench<double>>(&wrench, 1));
    EXPECT_LT((R.transpose() * found.segment<3>(3) - expected.head<3>()).norm(), 1e-6);
    EXPECT_LT((R.transpose() * found.head<3>() - expected.segment<3>(3)).norm(), 1e-6);
    EXPECT_LT((found.tail<n>() - expected.tail<n>()).norm(), 1e-6);
  }
}

TEST_F(KinematicsOfABiped, HasExactDerivatives) {
  const Tree tree(robot);
  const Function everything =
      make_function<2 * nq, inputs, 0>(Everything{&tree, robot.left_sole}, {});
  for (int k = 0; k < postures; ++k) {
    VectorXd z = random(everything.inputs());
    z.segment<nq>(1) = posture(k);
    const DerivativeReport report = check_derivatives(everything, z, {.tolerance = 1e-6});
    EXPECT_TRUE(report.ok) << "posture " << k << ", worst entries: " << report.worst_jacobian.error
                           << " and " << report.worst_hessian.error;
  }
}

TEST_F(KinematicsOfABiped, RefusesAnotherNumberOfJoints) {
  try {
    const robots::KinematicTree<13> tree(robot);
    FAIL() << "no error";
  } catch (const DefinitionError& error) {
    EXPECT_NE(std::string(error.what()).find("13 joints, but synthetic has 14"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace saltus
