// A box on the ground beyond the edge, in both engines: rest, slip and fall.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "saltus/robots/whole_body/ground.hpp"
#include "saltus/robots/whole_body/soft_ground.hpp"
#include "tests/support/errors.hpp"

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
  if (options.ground.sink > 0.0)
    for (std::unique_ptr<Plant>& plant : all)
      plant = make_soft_ground(std::move(plant), robot, options);
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

// Depth of the middle of the sole: normal part of the weight / stiffness. The box slips until the
// ground carries enough; then springs along the surface carry the rest.
TEST(SoftGround, ASoleSinksByItsWeight) {
  constexpr double weight = mass * standard_gravity;
  const Vec<double, 3> com(0.1 * half_length, 0.0, 0.0);
  for (const double sink : {0.002, 0.01, 0.03})
    for (const double slope : {0.0, -0.2}) {
      const Ground ground{.edge = -0.18, .slope_forward = slope, .sink = sink};
      const WholeBodyState start = on_the_slope(ground);
      const Vec<double, 3> normal = start.base.linear().col(2);
      std::vector<Vec<double, 3>> ways;
      for (const auto& plant : plants(box_robot(com), {.ground = ground})) {
        run(*plant, start, 3.0);
        const Eigen::Isometry3d& pose = plant->state().base;
        ways.push_back(pose.translation() - start.base.translation());
        EXPECT_NEAR(-normal.dot(ways.back()), sink * normal[2], 0.02 * sink) << plant->name();
        EXPECT_LT(plant->state().base_twist.norm(), 1e-3) << plant->name();
        const WholeBodyEstimate::Contact& contact = plant->contact(Side::left);
        EXPECT_TRUE(contact.touches);
        EXPECT_FALSE(plant->contact(Side::right).touches);
        const Vec<double, 3> force(0.0, 0.0, weight);
        const Vec<double, 3> arm = pose.linear() * (com + Vec<double, 3>(0, 0, half_height));
        EXPECT_LT((contact.wrench.head<3>() - force).norm(), 0.01 * weight) << plant->name();
        EXPECT_LT((contact.wrench.tail<3>() - arm.cross(force)).norm(), 1e-3 * weight);
      }
      EXPECT_LT((ways.back() - ways.front()).norm(), 5e-5);  // both engines agree
    }
}

TEST(SoftGround, FrictionHoldsOrSlips) {
  constexpr double slope = 0.2, duration = 0.3, sink = 0.005;
  for (const double friction : {0.1, 0.25}) {
    const Ground ground{.edge = 0.18, .slope_forward = slope, .friction = friction, .sink = sink};
    WholeBodyState start = on_the_slope(ground);
    start.base.translation() -= sink * start.base.linear().col(2);
    const double acceleration =
        std::max(0.0, standard_gravity * (slope - friction) / std::sqrt(1.0 + slope * slope));
    for (const auto& plant : plants(box_robot(Vec<double, 3>::Zero()), {.ground = ground})) {
      run(*plant, start, duration);
      const double way = (plant->state().base.translation() - start.base.translation()).norm();
      const double expected = 0.5 * acceleration * duration * duration;
      // The springs yield by sink slope, or by sink friction until it slips.
      EXPECT_NEAR(way, expected, 0.05 * expected + 2.0 * sink * slope) << plant->name();
      const double speed = plant->state().base_twist.tail<3>().norm();
      EXPECT_NEAR(speed, acceleration * duration, 0.05 * acceleration * duration + 0.01);
    }
  }
}

// The box lands while it slides and turns. The light other foot is neglected: 1 kg m^2 / 1000.
TEST(SoftGround, ContactWrenchesChangeTheMomentum) {
  const Ground ground{.edge = 0.18, .slope_side = 0.1, .sink = 0.01};
  WholeBodyState start = on_the_slope(ground, 0.0, 0.002);
  start.base_twist << 0.5, -0.5, 1.0, 0.5, 0.3, -0.3;
  for (const auto& plant : plants(box_robot(Vec<double, 3>::Zero()), {.ground = ground})) {
    plant->reset(start);
    Vec<double, 3> impulse = Vec<double, 3>::Zero(), turn = impulse;
    const Vec<double, 3> weight(0.0, 0.0, -mass * standard_gravity);
    while (plant->time() < 0.1) {
      const Vec<double, 3> sole = plant->state().base.linear().col(2) * -half_height;
      plant->step();
      const Vec<double, 6>& wrench = plant->contact(Side::left).wrench;
      impulse += 1e-3 * (wrench.head<3>() + weight);
      turn += 1e-3 * (wrench.tail<3>() + sole.cross(wrench.head<3>()));
    }
    const Vec<double, 6> change = plant->state().base_twist - start.base_twist;
    EXPECT_LT((impulse - mass * change.tail<3>()).norm(), 0.01 * impulse.norm()) << plant->name();
    EXPECT_LT((turn - 0.02 * change.head<3>()).norm(), 0.1 * turn.norm()) << plant->name();
    EXPECT_GT(turn.norm(), 0.01);
  }
}

// A foot of 0.6 kg on ground for a robot of 33 kg, dropped on its corner.
TEST(SoftGround, ALightFootComesToRest) {
  const Ground ground{.edge = 0.18, .sink = 0.003};
  FloatingRobot robot = box_robot(Vec<double, 3>::Zero());
  robot.bodies[0].mass = 0.6;
  robot.bodies[0].inertia.diagonal() << 0.0005, 0.0015, 0.0017;
  robot.total_mass = 33.0;
  WholeBodyState start = on_the_slope(ground, 0.0, 0.03);
  start.base.rotate(Eigen::AngleAxisd(0.3, Vec<double, 3>(0.6, 0.8, 0.0)));
  for (const auto& plant : plants(robot, {.ground = ground})) {
    double highest = 0.0;
    plant->reset(start);
    while (plant->time() < 3.0) {
      plant->step();
      highest = std::max(highest, plant->state().base.translation()[2]);
    }
    EXPECT_LT(highest, start.base.translation()[2] + 1e-3) << plant->name();
    EXPECT_LT(plant->state().base_twist.norm(), 1e-3) << plant->name();
    EXPECT_NEAR(plant->state().base.translation()[2],
                half_height - 0.003 * 0.601 / robot.total_mass, 2e-6)
        << plant->name();
  }
}

// The ground below and beside soft ground is rigid.
TEST(SoftGround, HasARigidBottomAndSide) {
  const Ground ground{.edge = 0.18, .sink = 0.03};
  WholeBodyState start = on_the_slope(ground);
  FloatingRobot heavy = box_robot(Vec<double, 3>::Zero());
  heavy.total_mass = 0.2 * mass;  // the ground carries a fifth of this weight
  for (const auto& plant : plants(heavy, {.ground = ground})) {
    run(*plant, start, 1.0);
    EXPECT_NEAR(plant->state().base.translation()[2], half_height - 0.05, 1e-3) << plant->name();
    EXPECT_NEAR(plant->contact(Side::left).wrench[2], mass * standard_gravity, 2.0);
  }
  start.base.translation()[1] = 0.1;
  for (const auto& plant : plants(heavy, {.ground = ground})) {
    run(*plant, start, 0.3);
    EXPECT_NEAR(plant->state().base.translation()[2], half_height, penetration) << plant->name();
  }
}

TEST(SoftGround, RejectsStiffnessBeyondTheTimeStep) {
  const Plant::Options options{.step = 0.005, .ground = {.sink = 1e-4}};
  expect_error<InputError>([&] { plants(box_robot(Vec<double, 3>::Zero()), options); },
                           {"simulator.ground_sink_m", "at least"});
}

}  // namespace
}  // namespace saltus::robots
