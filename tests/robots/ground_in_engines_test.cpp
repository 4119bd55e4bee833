// A box on the ground beyond the edge, in both engines: rest, slip and fall.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "saltus/robots/whole_body/ground.hpp"

namespace saltus::robots {
namespace {

using Ground = Plant::Ground;

constexpr double half_length = 0.08, half_width = 0.035, half_height = 0.01;  // m
constexpr double mass = 20.0;                                                 // kg

// A box whose underside is the left sole. The other foot is light and far above.
FloatingRobot box_robot(const Vec<double, 3>& com) {
  FloatingRobot robot;
  robot.name = "box";
  robot.bodies.resize(2);
  FloatingRobot::Body& box = robot.bodies[0];
  box.name = "box";
  box.mass = mass;
  box.com = com;
  box.inertia.diagonal().setConstant(0.02);
  box.boxes.push_back(
      {Eigen::Isometry3d::Identity(), 2.0 * Vec<double, 3>(half_length, half_width, half_height)});
  FloatingRobot::Body& other = robot.bodies[1];
  other.name = "other";
  other.parent = 0;
  other.joint = "joint";
  other.origin.translation() << 0.0, 0.0, 1.0;
  other.axis = Vec<double, 3>::UnitZ();
  other.mass = 1e-3;
  other.inertia.diagonal().setConstant(1e-4);
  robot.left_sole.pose.translation()[2] = -half_height;
  robot.right_sole.body = 1;
  robot.total_mass = mass;
  return robot;
}

// On the plane of the slopes, at the distance from the edge at which the height is given.
WholeBodyState on_the_slope(const Ground& ground, double x = 0.0, double rise = 0.0) {
  const double side = ground.edge > 0.0 ? 1.0 : -1.0;
  const Vec<double, 3> normal =
      Vec<double, 3>(-ground.slope_forward, -side * ground.slope_side, 1.0).normalized();
  WholeBodyState state;
  state.base.setIdentity();
  state.base.linear() =
      Eigen::Quaterniond::FromTwoVectors(Vec<double, 3>::UnitZ(), normal).toRotationMatrix();
  state.base.translation() =
      Vec<double, 3>(x, ground.edge + side * 0.06, ground.height + ground.slope_forward * x) +
      (half_height + rise) * normal;
  state.base_twist.setZero();
  state.q = state.dq = VectorXd::Zero(1);
  return state;
}

std::vector<std::unique_ptr<Plant>> plants(const FloatingRobot& robot,
                                           const Plant::Options& options) {
  std::vector<std::unique_ptr<Plant>> all;
  DartOptions dart;
  static_cast<Plant::Options&>(dart) = options;
  all.push_back(make_dart_plant(robot, dart));
  if (has_mujoco()) all.push_back(make_mujoco_plant(robot, options));
  return all;
}

void run(Plant& plant, const WholeBodyState& state, double duration) {
  plant.reset(state);
  while (plant.time() < duration - 1e-9) plant.step();
}

// MuJoCo's contacts yield by about 0.2 mm under this weight.
constexpr double penetration = 5e-4;  // m

// The CoM is above a corner region of the sole, so forces must act on its whole area.
TEST(GroundInEngines, ASoleRestsOnASlopeOnItsWholeArea) {
  const double weight = mass * standard_gravity;
  for (const double edge : {0.18, -0.18})
    for (const double slope : {0.1, -0.2})
      for (const double ahead : {-0.8, 0.8})
        for (const double left : {-0.7, 0.7}) {
          const Ground ground{
              .edge = edge, .height = 0.02, .slope_forward = slope, .slope_side = 0.15};
          const Vec<double, 3> com(ahead * half_length, left * half_width, 0.0);
          const WholeBodyState start = on_the_slope(ground, 0.0, 1e-3);
          const WholeBodyState rest = on_the_slope(ground);
          for (const auto& plant : plants(box_robot(com), {.ground = ground})) {
            run(*plant, start, 0.5);
            const Eigen::Isometry3d& pose = plant->state().base;
            EXPECT_LT((pose.translation() - rest.base.translation()).norm(), penetration)
                << plant->name() << slope << ahead << left;
            EXPECT_LT((pose.linear() - rest.base.linear()).norm(), 0.02) << plant->name();
            const WholeBodyEstimate::Contact& contact = plant->contact(Side::left);
            EXPECT_TRUE(contact.touches);
            const Vec<double, 3> force(0.0, 0.0, weight);
            const Vec<double, 3> arm = pose.linear() * (com + Vec<double, 3>(0, 0, half_height));
            EXPECT_LT((contact.wrench.head<3>() - force).norm(), 0.01 * weight) << plant->name();
            EXPECT_LT((contact.wrench.tail<3>() - arm.cross(force)).norm(), 1e-3 * weight)
                << plant->name();
          }
        }
}

// Acceleration g (sin - friction cos) down the slope; at rest if it is negative.
TEST(GroundInEngines, FrictionBeyondTheEdgeDecidesAboutSlip) {
  constexpr double slope = 0.2, duration = 0.3;
  for (const auto& [on_level, beyond] :
       {std::pair(1.0, 0.1), std::pair(0.1, 0.0), std::pair(0.1, 0.5), std::pair(0.5, 0.0)}) {
    const Ground ground{.edge = 0.18, .slope_forward = slope, .friction = beyond};
    const double friction = beyond > 0.0 ? beyond : on_level;
    const double acceleration =
        std::max(0.0, standard_gravity * (slope - friction) / std::sqrt(1.0 + slope * slope));
    const WholeBodyState start = on_the_slope(ground);
    for (const auto& plant :
         plants(box_robot(Vec<double, 3>::Zero()), {.friction = on_level, .ground = ground})) {
      run(*plant, start, duration);
      const double way = (plant->state().base.translation() - start.base.translation()).norm();
      const double expected = 0.5 * acceleration * duration * duration;
      EXPECT_NEAR(way, expected, 0.03 * expected + penetration) << plant->name() << friction;
    }
  }
}

TEST(GroundInEngines, TilesHaveTheirHeights) {
  const Ground ground{.edge = 0.18, .roughness = 0.02, .seed = 5};
  FloatingRobot robot = box_robot(Vec<double, 3>::Zero());
  robot.bodies[0].boxes[0].size << 0.06, 0.06, 2.0 * half_height;
  WholeBodyState state = on_the_slope(ground);
  const std::vector<GroundBox> boxes = ground_boxes({.ground = ground});
  for (const auto& plant : plants(robot, {.ground = ground}))
    for (const Vec<double, 2>& place : {Vec<double, 2>(0.05, 0.23), {-0.15, 0.33}, {1.05, 1.23}}) {
      const double height = height_at(boxes, place[0], place[1]) + half_height;
      state.base.translation() << place, height + 1e-3;
      run(*plant, state, 0.4);
      EXPECT_NEAR(plant->state().base.translation()[2], height, penetration) << plant->name();
    }
}

// The ground under half of the sole carries the box if the CoM is above it.
TEST(GroundInEngines, HalfASoleCarriesTheBox) {
  const Ground toes{.edge = 0.18, .end_forward = 0.0}, outer{.edge = 0.18, .end_side = 0.06};
  for (const Ground& ground : {toes, outer})
    for (const double side : {-1.0, 1.0}) {
      const Vec<double, 3> com = ground.end_forward
                                     ? Vec<double, 3>(side * 0.4 * half_length, 0.0, 0.0)
                                     : Vec<double, 3>(0.0, side * 0.4 * half_width, 0.0);
      for (const auto& plant : plants(box_robot(com), {.ground = ground})) {
        run(*plant, on_the_slope(ground), 0.5);
        const Eigen::Isometry3d& pose = plant->state().base;
        if (side < 0.0) {
          EXPECT_NEAR(pose.translation()[2], half_height, penetration) << plant->name();
          EXPECT_GT(pose(2, 2), 0.9999) << plant->name();
        } else {
          EXPECT_LT(pose(2, 2), 0.99) << plant->name();  // it has tipped
        }
      }
    }
}

}  // namespace
}  // namespace saltus::robots
