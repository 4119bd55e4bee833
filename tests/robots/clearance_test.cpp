// Distances of limbs, on iCub. Needs the URDF file named by SALTUS_ICUB_URDF.
#include "saltus/robots/whole_body/clearance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/robots/model/mesh.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "tests/robots/icub_body.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

constexpr std::uint64_t seed = 14;

class Limbs : public IcubBody {
 protected:
  void SetUp() override {
    IcubBody::SetUp();
    if (!IsSkipped()) robots::add_capsules(robot, *urdf, description);
  }
  robots::WholeBodyState random_state(Random& random) const {
    robots::WholeBodyState state = start;
    state.q += 0.5 * random.vector(robot.joints());
    state.dq = 3.0 * random.vector(robot.joints());
    state.base.translation() = random.vector(3);
    state.base.rotate(Eigen::AngleAxisd(random.uniform(-1.0, 1.0), Vec<double, 3>::UnitX()));
    return state;
  }
};

double distance_of(const robots::FloatingRobot& robot, const robots::Approach& pair,
                   robots::WholeBodyState state, double t, const VectorXd& acceleration) {
  state.q += t * state.dq + 0.5 * t * t * acceleration;
  robots::Clearance all(robot, 2000);
  all.update(state);
  for (int i = 0; i < all.count(); ++i)
    if (all.approach(i).first == pair.first && all.approach(i).second == pair.second)
      return all.approach(i).distance;
  return infinity;
}

TEST_F(Limbs, SpeedsMatchTheDistance) {
  Random random(seed);
  robots::Clearance clearance(robot, 8);
  VectorXd row(robot.joints());
  for (int k = 0; k < 10; ++k) {
    const robots::WholeBodyState state = random_state(random);
    clearance.update(state);
    ASSERT_EQ(clearance.count(), 8);
    for (int i = 0; i < clearance.count(); ++i) {
      const robots::Approach& a = clearance.approach(i);
      clearance.jacobian(i, row);
      EXPECT_NEAR(row.dot(state.dq), a.speed, 1e-12);
      // Central differences: an error of h^2 times third derivatives below 1e4 m/s^3.
      constexpr double h = 1e-4;
      const VectorXd none = VectorXd::Zero(robot.joints());
      const double before = distance_of(robot, a, state, -h, none);
      const double after = distance_of(robot, a, state, h, none);
      EXPECT_NEAR((after - before) / (2.0 * h), a.speed, 1e-4) << "seed " << seed;
    }
  }
}

// The closest points of balls do not move: at rest the second derivative is exact, in motion the
// omitted term is not negative.
TEST_F(Limbs, AccelerationsMatchTheDistanceOfBalls) {
  for (robots::FloatingRobot::Body& body : robot.bodies)
    for (robots::RobotDescription::LinkCapsule& c : body.capsules) c.capsule.to = c.capsule.from;
  Random random(seed);
  robots::Clearance clearance(robot, 8);
  VectorXd row(robot.joints());
  for (int k = 0; k < 20; ++k) {
    robots::WholeBodyState state = random_state(random);
    const bool at_rest = k % 2 == 0;
    if (at_rest) state.dq.setZero();
    const VectorXd acceleration = 10.0 * random.vector(robot.joints());
    clearance.update(state);
    for (int i = 0; i < clearance.count(); ++i) {
      const robots::Approach& a = clearance.approach(i);
      clearance.jacobian(i, row);
      constexpr double h = 1e-4;  // rounding by h^2: 1e-7 m/s^2
      const double difference = (distance_of(robot, a, state, h, acceleration) -
                                 2.0 * distance_of(robot, a, state, 0.0, acceleration) +
                                 distance_of(robot, a, state, -h, acceleration)) /
                                (h * h);
      const double expected = row.dot(acceleration) + a.drift;
      constexpr double tolerance = 1e-4;  // h^2 times fourth derivatives
      EXPECT_LE(expected, difference + tolerance) << "seed " << seed << ", " << clearance.names(a);
      if (at_rest) {
        EXPECT_NEAR(expected, difference, tolerance) << clearance.names(a);
      }
    }
  }
}

// Compares with a plain loop over all pairs: the nearest come first, and none is missing.
TEST_F(Limbs, KeepsTheNearestPairs) {
  Random random(seed);
  const robots::WholeBodyState state = random_state(random);
  robots::Clearance all(robot, 2000), few(robot, 5);
  all.update(state);
  few.update(state);
  ASSERT_EQ(few.count(), 5);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(few.approach(i).distance, all.approach(i).distance);
  for (int i = 1; i < all.count(); ++i)
    EXPECT_LE(all.approach(i - 1).distance, all.approach(i).distance);
  few.update(state, 0.5 * all.approach(0).distance + 0.5 * all.approach(1).distance);
  EXPECT_EQ(few.count(), 1);
  EXPECT_THROW(robots::Clearance(robot, 0), DefinitionError);
}

TEST_F(Limbs, CloseLimbsKeepHalfTheirDistance) {
  robots::Clearance clearance(robot, 4);
  clearance.update(start);
  ASSERT_EQ(clearance.count(), 4);
  EXPECT_EQ(clearance.approach(0).keep, infinity);
  const double nearest = clearance.approach(0).distance, next = clearance.approach(1).distance;
  clearance.stand(start, 0.25 * (nearest + next));
  clearance.update(start);
  EXPECT_DOUBLE_EQ(clearance.approach(0).keep, 0.5 * nearest);
  EXPECT_EQ(clearance.approach(1).keep, infinity);
}

TEST_F(Limbs, UpdatesDoNotAllocate) {
  robots::Clearance clearance(robot, 6);
  VectorXd row(robot.joints());
  const testing::AllocationCount count;
  clearance.update(start, 0.15, 0.1);
  for (int i = 0; i < clearance.count(); ++i) clearance.jacobian(i, row);
  EXPECT_EQ(count.made(), 0);
}

TEST_F(Limbs, NeighboursMayTouchAndOthersMayNot) {
  const auto apart = [this](const char* a, const char* b) {
    const auto find = [this](const char* link) {
      return robots::link_frame(robot, *urdf, link).body;
    };
    const std::pair<int, int> pair = std::minmax(find(a), find(b));
    return std::find(robot.apart.begin(), robot.apart.end(), pair) != robot.apart.end();
  };
  EXPECT_TRUE(apart("r_hand", "r_upper_leg"));
  EXPECT_TRUE(apart("l_foot", "r_foot"));
  EXPECT_TRUE(apart("l_hand", "head"));
  EXPECT_FALSE(apart("l_upper_leg", "l_lower_leg"));  // a joint between them
  EXPECT_FALSE(apart("l_hip_1", "l_upper_leg"));      // overlap by construction
}

TEST_F(Limbs, RejectsACollidingPosture) {
  for (const char* name : {"left_stance", "right_stance", "two_feet"}) {
    const robots::StandingPosture& posture = description.posture(name);
    EXPECT_NO_THROW(robots::expect_apart(
        robot, robots::standing_state(robot, *urdf, description, posture), name))
        << name;
  }
  robots::WholeBodyState folded = start;
  folded.q[robot.joint_index("l_hip_roll")] = -0.3;  // both legs inward
  folded.q[robot.joint_index("r_hip_roll")] = -0.3;
  expect_error<InputError>([&] { robots::expect_apart(robot, folded, "folded"); },
                           {"\"folded\"", "l_", "r_"});
}

// Compares the built-in file with the meshes if they are available.
TEST_F(Limbs, CapsulesOfTheFileMatchTheMeshes) {
  for (const robots::UrdfModel::Link& link : urdf->links())
    for (const robots::UrdfModel::LinkShape& visual : link.visuals)
      if (visual.shape == robots::UrdfModel::LinkShape::Shape::mesh &&
          !robots::find_mesh(visual.mesh, urdf_path))
        GTEST_SKIP() << "there is no mesh " << visual.mesh
                     << "; name its package in ROS_PACKAGE_PATH";
  robots::RobotDescription bare = description;
  bare.capsules.clear();
  robots::FloatingRobot fitted = robot;
  robots::add_capsules(fitted, *urdf, bare);
  EXPECT_EQ(fitted.apart, robot.apart);
  for (std::size_t b = 0; b < robot.bodies.size(); ++b) {
    const auto& expected = fitted.bodies[b].capsules;
    ASSERT_EQ(robot.bodies[b].capsules.size(), expected.size()) << robot.bodies[b].name;
    // The file is rounded to 0.1 mm; on other processors the search may take one iteration more or
    // less.
    constexpr double same = 1e-3;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const robots::Capsule& c = robot.bodies[b].capsules[i].capsule;
      EXPECT_EQ(robot.bodies[b].capsules[i].link, expected[i].link);
      EXPECT_NEAR(c.radius, expected[i].capsule.radius, same) << expected[i].link;
      EXPECT_LT((c.middle() - expected[i].capsule.middle()).norm(), same) << expected[i].link;
      EXPECT_NEAR(c.length(), expected[i].capsule.length(), 2.0 * same) << expected[i].link;
    }
  }
}

}  // namespace
}  // namespace saltus
