// Requirements on all whole-body controllers, and properties of each one. Needs the URDF, whose
// file SALTUS_ICUB_URDF names.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/clearance.hpp"
#include "saltus/robots/whole_body/contact_wrench.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"
#include "tests/robots/balance_on_the_left_foot.hpp"
#include "tests/robots/icub_body.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/dense_algebra.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

class Controllers : public IcubBody {
 protected:
  void SetUp() override {
    IcubBody::SetUp();
    if (IsSkipped()) return;
    model = robots::make_dart_dynamics(robot);
    left.foot = description.left_foot;
    right.foot = description.right_foot;
    inverse_dynamics = robots::make_inverse_dynamics_controller(robot, left, right);
    momentum = robots::make_momentum_controller(robot, left, right);
  }

  robots::WholeBodyState stand(const char* posture) {
    return robots::standing_state(robot, *urdf, description, description.posture(posture));
  }
  // Tasks at rest on both feet or on the left one: wrenches that carry the weight at zero momentum.
  robots::WholeBodyController::Tasks rest_tasks(const robots::WholeBodyState& state, bool both) {
    model->update(state);
    robots::WholeBodyController::Tasks tasks;
    tasks.right_stands = both;
    tasks.posture = state.q;
    const double weight = model->mass() * robots::standard_gravity;
    const double fraction =
        both ? (model->com() - model->sole(robots::Side::right).pose.translation())[1] /
                   (model->sole(robots::Side::left).pose.translation() -
                    model->sole(robots::Side::right).pose.translation())[1]
             : 1.0;
    const double loads[2] = {fraction * weight, (1.0 - fraction) * weight};
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      const int i = side == robots::Side::left ? 0 : 1;
      const Eigen::Isometry3d& pose = model->sole(side).pose;
      Vec<double, 3> arm = model->com() - pose.translation();
      if (both) arm[1] = 0.0;
      const Vec<double, 3> force(0.0, 0.0, loads[i]);
      tasks.wrenches.segment<3>(6 * i) = pose.linear().transpose() * force;
      tasks.wrenches.segment<3>(6 * i + 3) = pose.linear().transpose() * arm.cross(force);
    }
    return tasks;
  }

  // The same posture with velocities of all joints and the base, so that stance feet move too.
  robots::WholeBodyState moving(const char* posture) {
    robots::WholeBodyState state = stand(posture);
    for (int i = 0; i < robot.joints(); ++i) state.dq[i] = 0.1 * std::sin(1.0 + i);
    state.base_twist << 0.02, -0.03, 0.01, 0.01, 0.02, -0.01;
    return state;
  }
  static Vec<double, 6> planned(const robots::WholeBodyController::Tasks& tasks,
                                robots::Side side) {
    return tasks.wrenches.segment<6>(side == robots::Side::left ? 0 : 6);
  }

  std::unique_ptr<robots::DynamicsModel> model;
  robots::ContactCone::Options left, right;
  std::unique_ptr<robots::WholeBodyController> inverse_dynamics, momentum;
};

// At rest the torques balance gravity on every link: h minus the contact forces.
TEST_F(Controllers, TorquesBalanceGravityAtRest) {
  for (const bool both : {false, true}) {
    const robots::WholeBodyState state = stand(both ? "two_feet" : "left_stance");
    const robots::WholeBodyController::Tasks tasks = rest_tasks(state, both);
    VectorXd expected = model->bias();
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      const robots::DynamicsModel::SoleMotion& sole = model->sole(side);
      expected -=
          sole.jacobian.transpose() * (robots::wrench_to_world(sole) * planned(tasks, side));
    }
    // Tolerance of the programs, 1e-6, by their least weight, 1e-3 per N^2, times arms below 1 m.
    constexpr double tolerance = 1e-3;
    ASSERT_LT(expected.head<6>().cwiseAbs().maxCoeff(), tolerance);  // the feet carry the base
    for (auto* controller : {inverse_dynamics.get(), momentum.get()}) {
      const robots::WholeBodyController::Command& command =
          controller->control(*model, state, tasks);
      EXPECT_EQ(command.status, qp::QpStatus::optimal);
      EXPECT_LT((command.torques - expected.tail(robot.joints())).cwiseAbs().maxCoeff(), tolerance);
      EXPECT_LT((command.wrenches - tasks.wrenches).cwiseAbs().maxCoeff(), tolerance);
      EXPECT_LT(command.joint_acceleration.cwiseAbs().maxCoeff(), tolerance);
      EXPECT_LT(command.stance_slip, tolerance);
      EXPECT_LE(command.limit_excess, 0.0);
      EXPECT_EQ(command.torques_cut, 0);
    }
  }
}

TEST_F(Controllers, DoNotAllocate) {
  for (const bool both : {false, true, false}) {
    const robots::WholeBodyState state = moving(both ? "two_feet" : "left_stance");
    const robots::WholeBodyController::Tasks tasks = rest_tasks(state, both);
    for (auto* controller : {inverse_dynamics.get(), momentum.get()}) {
      const testing::AllocationCount count;
      controller->control(*model, state, tasks);
      EXPECT_EQ(count.made(), 0) << (controller == momentum.get() ? "momentum" : "inverse dynamics")
                                 << (both ? ", two feet" : ", one foot");
    }
  }
}

// The motors can exert half of the required torque. In the first call no torque has a row, and
// those above their limits get one. In the second call these rows exist from the start, and the
// program is the same.
TEST_F(Controllers, BoundTorquesAtTheirLimits) {
  const robots::WholeBodyState state = moving("two_feet");
  robots::WholeBodyController::Tasks tasks = rest_tasks(state, true);
  tasks.posture[robot.joint_index("l_knee")] += 0.5;
  const VectorXd free = inverse_dynamics->control(*model, state, tasks).torques;
  robots::FloatingRobot weak = robot;
  int weakened = 0;
  for (const char* joint : {"l_knee", "r_hip_pitch", "torso_pitch"}) {
    const int i = robot.joint_index(joint);
    if (std::abs(free[i]) < 0.5) continue;  // N m
    weak.bodies[static_cast<std::size_t>(i) + 1].effort = 0.5 * std::abs(free[i]);
    ++weakened;
  }
  ASSERT_GE(weakened, 2);
  const auto controller = robots::make_inverse_dynamics_controller(weak, left, right);
  const robots::WholeBodyController::Command found = controller->control(*model, state, tasks);
  const robots::WholeBodyController::Command again = controller->control(*model, state, tasks);
  for (const robots::WholeBodyController::Command* command : {&found, &again}) {
    EXPECT_EQ(command->status, qp::QpStatus::optimal);
    EXPECT_GT(command->solve_seconds, 0.0);
    int at_limit = 0;
    for (int i = 0; i < robot.joints(); ++i) {
      const double effort = weak.bodies[static_cast<std::size_t>(i) + 1].effort;
      EXPECT_LE(std::abs(command->torques[i]), effort);
      if (std::abs(command->torques[i]) > effort - 1e-4) ++at_limit;
    }
    EXPECT_GE(at_limit, 1);
  }
  EXPECT_LT(again.iterations, found.iterations);
  // The program is solved to 1e-6; its flattest direction, posture, costs 1e-2 or more.
  EXPECT_LT((again.torques - found.torques).lpNorm<Eigen::Infinity>(), 1e-3);
  EXPECT_LT((again.joint_acceleration - found.joint_acceleration).lpNorm<Eigen::Infinity>(), 1e-2);
}

// The equation of the paper, from the whole mass matrix and a pseudo-inverse by singular values.
TEST_F(Controllers, MomentumTorquesMatchTheEquation) {
  robots::WholeBodyController::MomentumOptions options;
  options.stance_regularisation = options.swing_regularisation = 1e-6;
  options.posture = 1.0;  // small enough for the torques to stay within their limits
  options.posture_damping = 2.0;
  momentum = robots::make_momentum_controller(robot, left, right, options);
  const int n = robot.joints();
  for (const bool both : {false, true}) {
    const robots::WholeBodyState state = moving(both ? "two_feet" : "left_stance");
    robots::WholeBodyController::Tasks tasks = rest_tasks(state, both);
    tasks.swing_acceleration << 0.1, -0.2, 0.3, 0.2, 0.1, 0.4;
    for (int i = 0; i < n; ++i) tasks.posture[i] += 0.05 * std::cos(3.0 * i);
    const robots::WholeBodyController::Command& command = momentum->control(*model, state, tasks);
    ASSERT_EQ(command.torques_cut, 0);

    const MatrixXd& M = model->mass_matrix();
    const VectorXd& h = model->bias();
    MatrixXd J(12, 6 + n), S = MatrixXd::Zero(6 + n, n);
    S.bottomRows(n).setIdentity();
    VectorXd force = VectorXd::Zero(6 + n);  // J_s' f
    Vec<double, 12> a;
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      const robots::DynamicsModel::SoleMotion& sole = model->sole(side);
      const int i = side == robots::Side::left ? 0 : 6;
      J.middleRows(i, 6) = sole.jacobian;
      const bool stands = side == robots::Side::left || both;
      a.segment<6>(i) =
          stands ? Vec<double, 6>(-options.stance_damping * sole.twist) : tasks.swing_acceleration;
      a.segment<6>(i) -= sole.drift;
      force += sole.jacobian.transpose() *
               (robots::wrench_to_world(sole) * command.wrenches.segment<6>(i));
    }
    const MatrixXd inverse = testing::inverse(M);
    const MatrixXd lambda = J * inverse * S;
    const MatrixXd pseudo = testing::pseudo_inverse(lambda);
    // The torques that would give the posture its accelerations if only f acted: eliminate the
    // base.
    const VectorXd wanted =
        options.posture * (tasks.posture - state.q) - options.posture_damping * state.dq;
    VectorXd nu(6 + n);
    nu.tail(n) = wanted;
    nu.head<6>() = testing::solver_of(M.topLeftCorner(6, 6))(force.head(6) - h.head(6) -
                                                             M.topRightCorner(6, n) * wanted);
    const VectorXd tau_0 = (M * nu + h - force).tail(n);
    const VectorXd expected = pseudo * (J * inverse * (h - force) + a) +
                              (MatrixXd::Identity(n, n) - pseudo * lambda) * tau_0;
    constexpr double tolerance = 1e-5;  // regularisation 1e-12 relative to min Lambda^2, 0.03
    EXPECT_LT((command.torques - expected).cwiseAbs().maxCoeff(), tolerance);

    // The ground then exerts f: the motion of the robot with fixed stance feet.
    const VectorXd motion = inverse * (S * command.torques + force - h);
    EXPECT_LT((J * motion - a).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_LT((motion.tail(n) - command.joint_acceleration).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_LT(command.stance_slip, 1e-5);
  }
}

TEST_F(Controllers, MomentumWrenchesRealiseTheRateWithinTheCones) {
  const robots::WholeBodyState state = moving("two_feet");
  robots::WholeBodyController::Tasks tasks = rest_tasks(state, true);
  tasks.force = {20.0, -30.0, 40.0};
  tasks.torque = {2.0, 1.0, 0.5};
  robots::WholeBodyController::MomentumOptions to_plan, to_torques;
  to_plan.wrench = to_torques.wrench = 1e-6;
  to_torques.torque = 1e-3;
  double norms[2];
  for (const int i : {0, 1}) {
    momentum = robots::make_momentum_controller(robot, left, right, i == 0 ? to_plan : to_torques);
    const robots::WholeBodyController::Command& command = momentum->control(*model, state, tasks);
    ASSERT_EQ(command.status, qp::QpStatus::optimal);
    Vec<double, 6> rate = Vec<double, 6>::Zero();
    for (const robots::Side side : {robots::Side::left, robots::Side::right})
      rate += robots::wrench_to_momentum(model->sole(side), model->com()) *
              command.wrenches.segment<6>(side == robots::Side::left ? 0 : 6);
    rate[2] -= model->mass() * robots::standard_gravity;
    // The other weights affect the rate, by about 1e-3 of its weight.
    EXPECT_LT((rate.head<3>() - tasks.force).norm(), 0.5) << i;
    EXPECT_LT((rate.tail<3>() - tasks.torque).norm(), 0.05) << i;
    EXPECT_LE(robots::contact_cone(left).violation(command.wrenches.head<6>()), 1e-5);
    EXPECT_LE(robots::contact_cone(right).violation(command.wrenches.tail<6>()), 1e-5);
    norms[i] = command.torques.norm();
  }
  EXPECT_LT(norms[1], 0.95 * norms[0]);  // two feet leave freedom to reduce the torques

  // More than one foot can exert: the wrenches stay in the cone and show the deficit.
  tasks.right_stands = false;
  tasks.force = {0.0, -300.0, 0.0};
  const robots::WholeBodyController::Command& command = momentum->control(*model, state, tasks);
  ASSERT_EQ(command.status, qp::QpStatus::optimal);
  EXPECT_LE(robots::contact_cone(left).violation(command.wrenches.head<6>()), 1e-5);
  EXPECT_EQ(command.wrenches.tail<6>().norm(), 0.0);
}

TEST_F(Controllers, MomentumTorquesAreClippedAndCounted) {
  const robots::WholeBodyState state = stand("left_stance");
  robots::WholeBodyController::Tasks tasks = rest_tasks(state, false);
  for (const int i : {0, 5, 20}) tasks.posture[i] += 6.0;  // rad; 300 rad/s^2 at once
  const robots::WholeBodyController::Command& command = momentum->control(*model, state, tasks);
  EXPECT_GT(command.torques_cut, 0);
  int at_limit = 0;
  for (int i = 0; i < robot.joints(); ++i) {
    EXPECT_LE(std::abs(command.torques[i]), robot.bodies[i + 1].effort);
    if (std::abs(command.torques[i]) == robot.bodies[i + 1].effort) ++at_limit;
  }
  EXPECT_EQ(at_limit, command.torques_cut);
  EXPECT_GT(command.stance_slip, 0.1);  // m/s^2: conflicting foot tasks are reported
}

TEST_F(Controllers, RejectsInvalidMomentumOptions) {
  robots::WholeBodyController::MomentumOptions options;
  options.wrench = 0.0;
  EXPECT_THROW(robots::make_momentum_controller(robot, left, right, options), DefinitionError);
  options = {};
  options.posture = -1.0;
  expect_error<DefinitionError>(
      [&] { robots::make_momentum_controller(robot, left, right, options); }, {"posture must be"});
}

TEST_F(Controllers, MomentumControlBalancesAPush) {
  const auto plant = robots::make_dart_plant(robot, {});
  plant->reset(start);
  balance_on_the_left_foot(robot, *model, *plant, *momentum, rest_tasks(start, false),
                           {.impulse = 2.0},
                           [](const robots::WholeBodyController::Command&, double) {});
}

// A sole that has tipped about an edge is turned back if the wrench acts on a corner: the centre of
// pressure keeps a distance to that edge. In the middle of the edge it may stay.
TEST_F(Controllers, LevelsATippedSole) {
  robots::WholeBodyController::Gains gains;
  gains.tipped_reserve = 10.0;
  const Bounds ends = left.foot.x;
  for (const double tilt : {0.0, 0.004, -0.004, 0.03})  // rad, positive: the toe is lifted
    for (const double y : {0.0, left.foot.y.lower - 0.005, left.foot.y.upper + 0.005}) {
      const bool on_corner = y != 0.0;  // exactly, without a compromise with other tasks
      const auto controller =
          robots::make_inverse_dynamics_controller(robot, left, right, {}, gains);
      robots::WholeBodyState state = stand("left_stance");
      model->update(state);
      const Eigen::Isometry3d sole = model->sole(robots::Side::left).pose;
      const double edge = tilt < 0.0 ? ends.upper : ends.lower;
      const Vec<double, 3> pivot = sole * Vec<double, 3>(edge, 0.0, 0.0);
      state.base = Eigen::Translation3d(pivot) * Eigen::AngleAxisd(-tilt, sole.linear().col(1)) *
                   Eigen::Translation3d(-pivot) * state.base;
      robots::WholeBodyController::Tasks tasks = rest_tasks(state, false);
      tasks.wrenches[3] = y * tasks.wrenches[2];
      tasks.wrenches[4] = -edge * tasks.wrenches[2];
      const Vec<double, 3> turning(tasks.wrenches[3], tasks.wrenches[4], 0.0);
      tasks.torque = model->sole(robots::Side::left).pose.linear() * turning;
      controller->control(*model, state, tasks);  // the first call detects the corner
      const robots::WholeBodyController::Command& command =
          controller->control(*model, state, tasks);
      EXPECT_EQ(command.status, qp::QpStatus::optimal);
      const double pressure = -command.wrenches[4] / command.wrenches[2];
      const double lifted =
          std::abs((ends.upper - ends.lower) * std::sin(tilt)) - gains.tipped_threshold;
      const double reserve =
          std::clamp(gains.tipped_reserve * lifted, 0.0, gains.most_tipped_reserve);
      // The tolerance is a tenth of a millimetre. That of the program, 1e-6 Nm, is far smaller for
      // a force of 300 N.
      EXPECT_NEAR(std::abs(pressure - edge), on_corner ? reserve : 0.0, 1e-4) << tilt << " " << y;
    }
}

// All tasks at rest, except for moving joints and approaching limbs.
TEST_F(Controllers, KeepSpeedLimitsAndClearances) {
  robots::add_capsules(robot, *urdf, description);
  robots::WholeBodyController::Gains gains;
  gains.speed_limits = gains.clearance = true;
  const auto keeping = robots::make_inverse_dynamics_controller(robot, left, right, {}, gains);
  robots::WholeBodyState state = stand("left_stance");
  const int elbow = robot.joint_index("l_elbow"), roll = robot.joint_index("r_shoulder_roll");
  const double fastest = robot.bodies[static_cast<std::size_t>(elbow) + 1].velocity;
  ASSERT_EQ(fastest, 7.64);
  state.dq[elbow] = fastest;  // above the margin
  state.q[roll] = 0.35;       // hand near the thigh, moving towards it
  state.dq[roll] = -1.0;
  robots::WholeBodyController::Tasks tasks = rest_tasks(state, false);
  tasks.posture[elbow] += 10.0;
  tasks.posture[roll] = -1.0;
  robots::Clearance clearance(robot, 1);
  clearance.update(state);
  VectorXd row(robot.joints());
  clearance.jacobian(0, row);
  const robots::Approach& near = clearance.approach(0);
  ASSERT_GT(near.distance, 0.0);
  ASSERT_LT(near.speed, 0.0);
  const auto change_of_speed = [&](const robots::WholeBodyController::Command& command) {
    return row.dot(command.joint_acceleration) + near.drift;
  };
  for (auto* controller : {inverse_dynamics.get(), keeping.get()}) {
    const testing::AllocationCount count;
    const robots::WholeBodyController::Command& command = controller->control(*model, state, tasks);
    EXPECT_EQ(count.made(), 0);
    EXPECT_EQ(command.status, qp::QpStatus::optimal);
    const bool keeps = controller == keeping.get();
    const double margin = gains.speed_margin * fastest;
    EXPECT_EQ(command.joint_acceleration[elbow] < -0.9 * margin * 4.0 / gains.limit_horizon, keeps);
    const double T = gains.clearance_horizon;
    const double least = 4.0 / (T * T) * (gains.clearance_margin - near.distance - T * near.speed);
    EXPECT_EQ(change_of_speed(command) > least - 0.01 * std::abs(least), keeps)
        << change_of_speed(command) << " against " << least;
  }
}

// At six times its speed limit, the elbow brakes with the full motor torque. The constraints of its
// position limit and of its speed limit exclude each other.
TEST_F(Controllers, BrakesAJointAboveItsSpeedLimit) {
  robots::WholeBodyController::Gains gains;
  gains.speed_limits = true;
  const auto keeping = robots::make_inverse_dynamics_controller(robot, left, right, {}, gains);
  robots::WholeBodyState state = stand("left_stance");
  const int elbow = robot.joint_index("l_elbow");
  const robots::FloatingRobot::Body& body = robot.bodies[static_cast<std::size_t>(elbow) + 1];
  state.dq[elbow] = 6.0 * body.velocity;
  const robots::WholeBodyController::Tasks tasks = rest_tasks(state, false);
  const robots::WholeBodyController::Command& command = keeping->control(*model, state, tasks);
  EXPECT_EQ(command.status, qp::QpStatus::optimal);
  constexpr double solved = 1e-4;  // Nm, accuracy of the program
  EXPECT_NEAR(command.torques[elbow], -body.effort, solved);
}

}  // namespace
}  // namespace saltus
