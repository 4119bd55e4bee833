// Settings for a robot of a different size: by dynamic similarity, lengths by L and forces by M.
#include <gtest/gtest.h>

#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::robots::walking {
namespace {

TEST(Scaling, DefaultRobotHasScaleOne) {
  RobotDescription robot = icub();
  EXPECT_EQ(scale_of(robot).mass, 1.0);
  EXPECT_EQ(scale_of(robot).length, 1.0);
  robot.mass *= 1.5;
  robot.postures.front().com[2] *= 0.75;
  EXPECT_EQ(scale_of(robot).mass, 1.5);
  EXPECT_EQ(scale_of(robot).length, 0.75);
}

// Powers of two: nothing is rounded.
TEST(Scaling, WeightsScaleInverselyWithSquaredQuantities) {
  constexpr double M = 4.0, L = 2.0;
  const BipedSettings before;
  BipedSettings after;
  scale(after, {M, L});
  EXPECT_EQ(after.step.duration, before.step.duration);
  EXPECT_EQ(after.step.fixed_place, L * before.step.fixed_place);
  EXPECT_EQ(after.step.lateral_min, L * before.step.lateral_min);
  EXPECT_EQ(after.step.lateral_max, L * before.step.lateral_max);
  EXPECT_EQ(after.step.forward_max, L * before.step.forward_max);
  EXPECT_EQ(after.contact.friction, before.contact.friction);
  EXPECT_EQ(after.contact.normal_force_min, M * before.contact.normal_force_min);
  EXPECT_EQ(after.contact.normal_force_max, M * before.contact.normal_force_max);
  EXPECT_EQ(after.contact.torsional_friction, L * before.contact.torsional_friction);
  EXPECT_EQ(after.plant.estimation.standing_force, M * before.plant.estimation.standing_force);
  const auto expect_scaled = [](const auto& scaled, const auto& original) {
    EXPECT_EQ(scaled.linear_momentum * M * M, original.linear_momentum);
    EXPECT_EQ(scaled.angular_momentum * M * M * L * L, original.angular_momentum);
    EXPECT_EQ(scaled.wrench * M * M, original.wrench);
  };
  expect_scaled(after.control.inverse_dynamics, before.control.inverse_dynamics);
  expect_scaled(after.control.momentum, before.control.momentum);
  EXPECT_EQ(after.control.inverse_dynamics.posture,
            L * L * before.control.inverse_dynamics.posture);
}

}  // namespace
}  // namespace saltus::robots::walking
