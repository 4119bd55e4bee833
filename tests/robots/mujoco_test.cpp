// MuJoCo as a second engine: it must have the same robot model as DART, obey the laws of motion,
// and agree on the result of a push. Needs the URDF file named by SALTUS_ICUB_URDF.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "saltus/core/error.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "saltus/robots/whole_body/clearance.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"
#include "tests/robots/icub_body.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

constexpr unsigned seed = 7;

class Mujoco : public IcubBody {
 protected:
  void SetUp() override {
    if (!robots::has_mujoco()) GTEST_SKIP() << "built without MuJoCo";
    IcubBody::SetUp();
    if (IsSkipped()) return;
    dynamics = robots::make_dart_dynamics(robot);
    RecordProperty("seed", static_cast<int>(seed));
  }

  VectorXd random(int n, double scale) {
    std::uniform_real_distribution<double> uniform(-scale, scale);
    return VectorXd::NullaryExpr(n, [&] { return uniform(numbers); });
  }
  // High above the ground, turned, every joint and the base in motion.
  robots::WholeBodyState flying() {
    robots::WholeBodyState s = start;
    const Vec<double, 3> axis = random(3, 1.0);
    s.base.linear() = Eigen::AngleAxisd(1.2, axis.normalized()).toRotationMatrix();
    s.base.translation() = Vec<double, 3>(0.3, -0.2, 3.0);
    s.base_twist = random(6, 1.0);
    s.dq = random(robot.joints(), 1.0);
    return s;
  }
  // Momentum of the whole robot about the world's origin: (angular | linear).
  Vec<double, 6> momentum(const robots::WholeBodyState& state) {
    dynamics->update(state);
    Vec<double, 6> h;
    h.tail<3>() = dynamics->mass() * dynamics->com_velocity();
    h.head<3>() = dynamics->angular_momentum() + dynamics->com().cross(h.tail<3>());
    return h;
  }

  std::unique_ptr<robots::DynamicsModel> dynamics;
  std::mt19937 numbers{seed};
};

TEST_F(Mujoco, HasTheMassMatrixOfDart) {
  for (int trial = 0; trial < 3; ++trial) {
    robots::WholeBodyState state = flying();
    state.q += random(robot.joints(), 0.5);
    dynamics->update(state);
    const MatrixXd mass_matrix = robots::mujoco_mass_matrix(robot, state);
    // The sum over the bodies. The sum over the URDF is 33.0617 kg.
    EXPECT_NEAR(mass_matrix(3, 3), 33.0617, 5e-5);
    // MuJoCo diagonalises the inertias with rounding: measured 1.2e-8 of 33 kg.
    EXPECT_LT((mass_matrix - dynamics->mass_matrix()).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST_F(Mujoco, ReturnsTheGivenState) {
  const auto plant = robots::make_mujoco_plant(robot, {});
  const robots::WholeBodyState given = flying();
  plant->reset(given);
  const robots::WholeBodyState& s = plant->state();
  constexpr double rounding = 1e-13;
  EXPECT_LT((s.base.matrix() - given.base.matrix()).cwiseAbs().maxCoeff(), rounding);
  EXPECT_LT((s.base_twist - given.base_twist).cwiseAbs().maxCoeff(), rounding);
  EXPECT_LT((s.q - given.q).cwiseAbs().maxCoeff(), rounding);
  EXPECT_LT((s.dq - given.dq).cwiseAbs().maxCoeff(), rounding);
  EXPECT_EQ(plant->time(), 0.0);
}

// Torques, pushes, gravity and Coriolis forces at once: one very short step shows the acceleration.
TEST_F(Mujoco, AcceleratesAsDartDoes) {
  robots::Plant::Options options;
  options.step = 1e-6;
  options.joint_friction = 0.3;
  robots::DartOptions dart_options;
  static_cast<robots::Plant::Options&>(dart_options) = options;
  const auto mujoco = robots::make_mujoco_plant(robot, options);
  const auto dart = robots::make_dart_plant(robot, dart_options);
  for (int trial = 0; trial < 3; ++trial) {
    const robots::WholeBodyState state = flying();
    const VectorXd torques = random(robot.joints(), 100.0);  // also beyond the limits
    const Vec<double, 3> force = random(3, 50.0), point = random(3, 0.2);
    const int chest = robot.body_index("chest");
    VectorXd acceleration[2];
    int k = 0;
    for (robots::Plant* plant : {mujoco.get(), dart.get()}) {
      plant->reset(state);
      plant->set_torques(torques);
      plant->push(chest, force, point);
      plant->push(chest, 0.5 * force, -point);  // pushes add up
      plant->step();
      VectorXd& a = acceleration[k++];
      a.resize(6 + robot.joints());
      a << plant->state().base_twist - state.base_twist, plant->state().dq - state.dq;
      a /= options.step;
    }
    // The engines hold different velocities constant over the step of 1e-6 s, and differences of
    // velocities lose digits; measured 2e-8.
    const double scale = acceleration[1].cwiseAbs().maxCoeff();
    EXPECT_GT(scale, 10.0);
    EXPECT_LT((acceleration[0] - acceleration[1]).cwiseAbs().maxCoeff(), 1e-6 * scale);
  }
}

TEST_F(Mujoco, FallsFreely) {
  const auto plant = robots::make_mujoco_plant(robot, {});
  robots::WholeBodyState state = start;
  state.base.translation()[2] += 1.0;
  plant->reset(state);
  for (int k = 0; k < 100; ++k) plant->step();
  EXPECT_NEAR(plant->time(), 0.1, 1e-12);
  const Vec<double, 6> twist = plant->state().base_twist;
  // Gravity accelerates all bodies equally, so no joint moves except for rounding.
  EXPECT_NEAR(twist[5], -robots::standard_gravity * 0.1, 1e-9);
  EXPECT_LT(twist.head<5>().cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(plant->state().dq.cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_FALSE(plant->contact(robots::Side::left).touches);
}

// The robot lands on its left foot, slips and rotates, without joint torques. The reported sole
// wrenches must equal the change of its linear and angular momentum.
TEST_F(Mujoco, ContactWrenchesChangeTheMomentum) {
  robots::Plant::Options options;
  options.step = 1e-4;
  options.friction = 0.5;
  const auto plant = robots::make_mujoco_plant(robot, options);
  robots::WholeBodyState state = start;
  state.base.translation() += Vec<double, 3>(0.2, 0.1, 0.005);
  state.base_twist << 0.1, 0.2, 0.3, 0.4, 0.2, -0.3;
  plant->reset(state);
  Vec<double, 6> expected = momentum(state), impulse = Vec<double, 6>::Zero();
  const double weight = robot.total_mass * robots::standard_gravity;
  double normal = 0.0, tangential = 0.0;
  long allocations = 0;
  for (int k = 0; k < 1500; ++k) {
    dynamics->update(plant->state());
    const Vec<double, 3> com = dynamics->com();
    const Vec<double, 3> sole[2] = {dynamics->sole(robots::Side::left).pose.translation(),
                                    dynamics->sole(robots::Side::right).pose.translation()};
    const saltus::testing::AllocationCount count;
    plant->step();
    allocations += count.made();
    Vec<double, 6> rate;
    rate.tail<3>() = Vec<double, 3>(0.0, 0.0, -weight);
    rate.head<3>() = com.cross(rate.tail<3>());
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      const Vec<double, 6>& w = plant->contact(side).wrench;
      const Vec<double, 3>& origin = sole[side == robots::Side::left ? 0 : 1];
      rate.tail<3>() += w.head<3>();
      rate.head<3>() += w.tail<3>() + origin.cross(w.head<3>());
      normal += w[2];
      tangential += w.head<2>().norm();
      // The cone is round and exact.
      EXPECT_LE(w.head<2>().norm(), options.friction * w[2] + 1e-6);
    }
    impulse += options.step * rate;
  }
  EXPECT_GT(options.step * normal, 5.0);  // Ns: the landing was significant
  EXPECT_GT(tangential, 0.1 * normal);    // and friction
  EXPECT_EQ(allocations, 0);
  expected += impulse;
  const Vec<double, 6> found = momentum(plant->state());
  // First order in the step of 0.1 ms: measured 0.004 of a normal impulse of 38 Ns.
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 0.01) << found.transpose() << "\n"
                                                            << expected.transpose();
}

TEST_F(Mujoco, StandsOnOneFootWithItsWeightOnTheSole) {
  const auto plant = robots::make_mujoco_plant(robot, {});
  plant->reset(start);
  dynamics->update(start);
  const auto controller = standing_controller();
  robots::WholeBodyController::Tasks tasks = tasks_on_the_left_foot();
  const double weight = robot.total_mass * robots::standard_gravity;
  const Vec<double, 3> com = dynamics->com();
  Vec<double, 6> mean = Vec<double, 6>::Zero();
  constexpr int steps = 2000, last = 200;  // each 1 ms
  for (int k = 0; k < steps; ++k) {
    if (k % 2 == 0) {
      dynamics->update(plant->state());
      tasks.force =
          robot.total_mass * (50.0 * (com - dynamics->com()) - 14.0 * dynamics->com_velocity());
      tasks.torque = -5.0 * dynamics->angular_momentum();
      tasks.swing_acceleration = -20.0 * dynamics->sole(robots::Side::right).twist;
      const robots::WholeBodyController::Command& command =
          controller->control(*dynamics, plant->state(), tasks);
      ASSERT_EQ(command.status, qp::QpStatus::optimal) << k;
      plant->set_torques(command.torques);
    }
    plant->step();
    ASSERT_TRUE(plant->state().is_finite()) << k;
    EXPECT_FALSE(plant->contact(robots::Side::right).touches) << k;
    if (k >= steps - last) mean += plant->contact(robots::Side::left).wrench / last;
  }
  dynamics->update(plant->state());
  // The ground carries the weight except for residual motion: measured 3e-7 of it, and a
  // CoM 0.02 mm away at 0.004 mm/s. The limits leave room for another release of MuJoCo.
  EXPECT_NEAR(mean[2], weight, 1e-4 * weight);
  EXPECT_LT(mean.head<2>().norm(), 1e-4 * weight);
  EXPECT_LT((dynamics->com() - com).norm(), 1e-3);
  EXPECT_LT(dynamics->com_velocity().norm(), 1e-3);
  const Vec<double, 3> sole = dynamics->sole(robots::Side::left).pose.translation();
  EXPECT_LT(sole.head<2>().norm(), 1e-4);  // no slip
  // The centre of pressure lies under the CoM.
  const Vec<double, 2> pressure(-mean[4] / mean[2], mean[3] / mean[2]);
  EXPECT_LT((pressure + sole.head<2>() - dynamics->com().head<2>()).norm(), 1e-4);
}

TEST_F(Mujoco, FailsSilentlyWithAMessage) {
  const auto plant = robots::make_mujoco_plant(robot, {});
  plant->reset(start);
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  plant->push(0, {1e200, 0.0, 0.0}, {0.0, 0.0, 0.0});
  for (int k = 0; k < 3; ++k) plant->step();
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_FALSE(std::filesystem::exists("MUJOCO_LOG.TXT"));
  EXPECT_FALSE(plant->state().is_finite());
  plant->reset(start);
  plant->step();
  EXPECT_TRUE(plant->state().is_finite());

  robots::FloatingRobot impossible = robot;
  impossible.bodies[3].inertia = Vec<double, 3>(1.0, 1.0, 5.0).asDiagonal();
  expect_error<InputError>([&] { robots::make_mujoco_plant(impossible, {}); }, {"inertia"});
}

TEST(WithoutMujoco, ThePlantReportsIt) {
  if (robots::has_mujoco()) GTEST_SKIP() << "built with MuJoCo";
  expect_error<InputError>([] { robots::make_mujoco_plant({}, {}); }, {"built without MuJoCo"});
}

// Both engines, with capsules.
class LimbsInBothEngines : public Mujoco {
 protected:
  void SetUp() override {
    Mujoco::SetUp();
    if (!IsSkipped()) robots::add_capsules(robot, *urdf, description);
  }
  std::vector<std::unique_ptr<robots::Plant>> plants(bool self_collision) const {
    robots::DartOptions dart;
    dart.self_collision = self_collision;
    robots::Plant::Options options;
    options.self_collision = self_collision;
    std::vector<std::unique_ptr<robots::Plant>> both;
    both.push_back(robots::make_dart_plant(robot, dart));
    both.push_back(robots::make_mujoco_plant(robot, options));
    return both;
  }
};

// In the air, torques pull the right arm to the body. Limbs in contact stop, and their contact
// forces do not change the momentum.
TEST_F(LimbsInBothEngines, LimbsStopAtEachOther) {
  robots::WholeBodyState state = start;
  state.base.translation()[2] += 3.0;
  VectorXd torques = VectorXd::Zero(robot.joints());
  torques[robot.joint_index("r_shoulder_roll")] = -5.0;
  robots::Clearance clearance(robot, 1);
  for (const bool self_collision : {false, true})
    for (const auto& plant : plants(self_collision)) {
      plant->reset(state);
      double least = infinity;
      while (plant->time() < 0.4) {
        plant->set_torques(torques);
        plant->step();
        clearance.update(plant->state());
        least = std::min(least, clearance.approach(0).distance);
      }
      // MuJoCo's contacts are soft: limbs overlap slightly under a torque of 5 Nm.
      if (self_collision)
        EXPECT_GT(least, -0.005) << plant->name();
      else
        EXPECT_LT(least, -0.02) << plant->name();
      dynamics->update(plant->state());
      const double fall = robots::standard_gravity * plant->time();
      EXPECT_NEAR(dynamics->com_velocity()[2], -fall, 0.01 * fall) << plant->name();
      EXPECT_LT(dynamics->angular_momentum().norm(), 0.05) << plant->name();
    }
}

TEST_F(LimbsInBothEngines, RejectDetectorsWithoutCapsules) {
  for (const robots::DartOptions::Collision detector :
       {robots::DartOptions::Collision::dart, robots::DartOptions::Collision::fcl}) {
    robots::DartOptions options;
    options.collision = detector;
    EXPECT_NO_THROW(robots::make_dart_plant(robot, options));
    options.self_collision = true;
    EXPECT_THROW(robots::make_dart_plant(robot, options), InputError);
  }
}

// Soles are boxes. A foot's capsule only touches other limbs, however low it is.
TEST_F(LimbsInBothEngines, CapsulesOfFeetDoNotTouchTheGround) {
  robots::FloatingRobot low = robot;
  const robots::FloatingRobot::Frame& sole = low.left_sole;
  robots::RobotDescription::LinkCapsule capsule;
  capsule.capsule = {sole.pose * Vec<double, 3>(-0.02, 0.0, 0.0),
                     sole.pose * Vec<double, 3>(0.02, 0.0, 0.0), 0.03};
  low.bodies[static_cast<std::size_t>(sole.body)].capsules.push_back(capsule);
  const auto all = plants(true);
  std::swap(robot, low);
  const auto all_low = plants(true);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const auto& plant : {all[i].get(), all_low[i].get()}) {
      plant->reset(start);
      plant->step();
    }
    EXPECT_EQ(all[i]->state().base_twist, all_low[i]->state().base_twist) << all[i]->name();
    EXPECT_EQ(all[i]->contact(robots::Side::left).wrench,
              all_low[i]->contact(robots::Side::left).wrench)
        << all[i]->name();
  }
}

// Without torques the robot falls forward. Then only its feet may be below the ground.
TEST_F(LimbsInBothEngines, FallenLimbsRestOnTheGround) {
  const VectorXd torques = VectorXd::Zero(robot.joints());
  for (const auto& plant : plants(true)) {
    plant->reset(start);
    while (plant->time() < 3.0) {
      plant->set_torques(torques);
      plant->step();
    }
    robots::Clearance clearance(robot, 1);
    clearance.update(plant->state());
    double lowest = infinity;
    for (std::size_t i = 0; i < clearance.members().size(); ++i) {
      const int body = clearance.members()[i].body;
      if (body == robot.left_sole.body || body == robot.right_sole.body) continue;
      const robots::Capsule capsule = clearance.capsule(static_cast<int>(i));
      lowest =
          std::min({lowest, capsule.from.z() - capsule.radius, capsule.to.z() - capsule.radius});
    }
    EXPECT_GT(lowest, -0.01) << plant->name();
    EXPECT_LT(lowest, 0.02) << plant->name();
    EXPECT_LT(plant->state().base.translation().z(), 0.3) << plant->name();
  }
}

}  // namespace
}  // namespace saltus
