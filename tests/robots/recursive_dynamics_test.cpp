// Compares the recursive dynamics with an independent formulation, and counts their allocations.
#include "saltus/robots/whole_body/recursive_dynamics.hpp"

#include <gtest/gtest.h>

#include "saltus/core/random.hpp"
#include "tests/robots/synthetic_balance.hpp"
#include "tests/robots/tree_dynamics.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::robots {
namespace {

// Rounding of sums of about 100 terms, relative to the largest entry.
template <class A, class B>
void expect_near(const A& ours, const B& theirs, const char* what) {
  EXPECT_LT((ours - theirs).cwiseAbs().maxCoeff(), 1e-12 * (1.0 + theirs.cwiseAbs().maxCoeff()))
      << what;
}

TEST(RecursiveDynamics, AgreesWithJacobiansOfAllBodies) {
  walking::SyntheticBalance biped;
  FloatingRobot robot = biped.robot;
  for (FloatingRobot::Body& body : robot.bodies) body.drive.rotor_inertia = 0.0;
  TreeDynamics theirs(robot);
  const std::unique_ptr<DynamicsModel> ours = make_recursive_dynamics(robot);
  EXPECT_EQ(ours->mass(), theirs.mass());
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    WholeBodyState state = biped.start;
    state.base =
        Eigen::Translation3d(random.vector(3)) *
        Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Vec<double, 3>(random.vector(3)).normalized());
    state.base_twist = random.vector(6);
    state.q = random.vector(robot.joints());
    state.dq = 3.0 * random.vector(robot.joints());
    theirs.update(state);
    const saltus::testing::AllocationCount count;
    ours->update(state);
    EXPECT_EQ(count.made(), 0);
    expect_near(ours->mass_matrix(), theirs.mass_matrix(), "mass matrix");
    expect_near(ours->bias(), theirs.bias(), "bias");
    expect_near(ours->com(), theirs.com(), "centre of mass");
    expect_near(ours->com_velocity(), theirs.com_velocity(), "its velocity");
    expect_near(ours->angular_momentum(), theirs.angular_momentum(), "angular momentum");
    for (const Side side : {Side::left, Side::right}) {
      expect_near(ours->sole(side).pose.matrix(), theirs.sole(side).pose.matrix(), "sole");
      expect_near(ours->sole(side).twist, theirs.sole(side).twist, "twist");
      expect_near(ours->sole(side).jacobian, theirs.sole(side).jacobian, "jacobian");
      expect_near(ours->sole(side).drift, theirs.sole(side).drift, "drift");
    }
  }
}

TEST(RecursiveDynamics, AddsTheRotors) {
  walking::SyntheticBalance biped;
  const std::unique_ptr<DynamicsModel> without = make_recursive_dynamics(biped.robot);
  FloatingRobot robot = biped.robot;
  for (FloatingRobot::Body& body : robot.bodies) body.drive.rotor_inertia += 0.125;
  const std::unique_ptr<DynamicsModel> with = make_recursive_dynamics(robot);
  with->update(biped.start);
  without->update(biped.start);
  MatrixXd expected = without->mass_matrix();
  expected.diagonal().tail(robot.joints()).array() += 0.125;
  expect_near(with->mass_matrix(), expected, "mass matrix");
}

}  // namespace
}  // namespace saltus::robots
