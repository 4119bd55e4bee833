// The simulated robot: noise of the requested size, delayed torques.
#include "saltus/robots/simulation/simulated_robot.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots::walking {
namespace {

constexpr int joints = 4;

// A plant at rest that records the torques of every step.
class StillPlant final : public Plant {
 public:
  explicit StillPlant(std::vector<double>* acting = nullptr) : acting_(acting) {
    state_.base.translation() << 1.0, 2.0, 3.0;
    state_.base.rotate(Eigen::AngleAxisd(0.7, Vec<double, 3>(1.0, 2.0, 2.0) / 3.0));
    state_.base_twist.setConstant(0.5);
    state_.q = VectorXd::LinSpaced(joints, -1.0, 1.0);
    state_.dq = VectorXd::Constant(joints, 0.25);
    contacts_[0].touches = true;
    contacts_[0].wrench << 3.0, -4.0, 300.0, 1.0, -2.0, 0.5;
  }
  void reset(const WholeBodyState& state) override { state_ = state; }
  void set_torques(const VectorXd& torques) override { torque_ = torques[0]; }
  void set_rotor_inertias(const VectorXd&) override {}
  void push(int, const Vec<double, 3>&, const Vec<double, 3>&) override {}
  void step() override {
    if (acting_ != nullptr) acting_->push_back(torque_);
  }
  double time() const override { return 0.0; }
  const WholeBodyState& state() const override { return state_; }
  const WholeBodyEstimate::Contact& contact(Side side) const override {
    return contacts_[side == Side::left ? 0 : 1];
  }
  std::string name() const override { return "still"; }

 private:
  WholeBodyState state_;
  WholeBodyEstimate::Contact contacts_[2];
  double torque_ = 0.0;
  std::vector<double>* acting_;
};

// The body of that plant; its drives have no limits.
FloatingRobot still_body() {
  FloatingRobot body;
  body.bodies.resize(joints + 1);
  return body;
}

MeasurementNoise some_noise() {
  MeasurementNoise noise;
  noise.position = 1e-3;
  noise.angle = 2e-3;
  noise.velocity = 3e-3;
  noise.angular_velocity = 4e-3;
  noise.force = 5e-2;
  return noise;
}

// The control period is two engine steps.
SimulatedRobot robot_with(const MeasurementNoise& noise, int delay_ticks = 0,
                          std::vector<double>* acting = nullptr) {
  PlantSettings settings;
  settings.noise = noise;
  settings.delay_ticks = delay_ticks;
  return {std::make_unique<StillPlant>(acting), still_body(), settings, 2.0 * settings.engine.step};
}
const WholeBodyState& measured(const SimulatedRobot& robot) { return robot.read().ideal->state; }

struct Spread {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  double deviation() const { return std::sqrt(squares / count); }
  double mean() const { return sum / count; }
};

TEST(SimulatedRobot, NoiseHasTheRequestedDeviation) {
  const MeasurementNoise noise = some_noise();
  SimulatedRobot robot = robot_with(noise);
  const StillPlant still;
  Spread position, turn, velocity, angular, joint, speed, force;
  constexpr int steps = 4000;
  for (int k = 0; k < steps; ++k) {
    robot.wait();
    const WholeBodyState& s = measured(robot);
    const WholeBodyState& t = still.state();
    const Eigen::AngleAxisd off(s.base.linear() * t.base.linear().transpose());
    for (int i = 0; i < 3; ++i) {
      position.add(s.base.translation()[i] - t.base.translation()[i]);
      turn.add(off.angle() * off.axis()[i]);
      angular.add(s.base_twist[i] - t.base_twist[i]);
      velocity.add(s.base_twist[3 + i] - t.base_twist[3 + i]);
    }
    for (int i = 0; i < joints; ++i) {
      joint.add(s.q[i] - t.q[i]);
      speed.add(s.dq[i] - t.dq[i]);
    }
    for (int i = 0; i < 6; ++i)
      force.add(robot.read().ideal->left.wrench[i] / still.contact(Side::left).wrench[i] - 1.0);
    ASSERT_TRUE(robot.read().ideal->right.wrench.isZero());  // a foot in the air has no noise
    ASSERT_EQ((robot.engine().state().q - t.q).norm(), 0.0);
    ASSERT_EQ((robot.engine().state().base.matrix() - t.base.matrix()).norm(), 0.0);
  }
  // With 12000 samples or more, the standard deviation is known to 0.7 % and the mean to 0.9 % of
  // it. The limits are five times as large.
  constexpr double deviation_error = 0.035, mean_error = 0.045;
  const auto check = [&](const Spread& s, double wanted, const char* what) {
    EXPECT_NEAR(s.deviation(), wanted, deviation_error * wanted) << what;
    EXPECT_NEAR(s.mean(), 0.0, mean_error * wanted) << what;
  };
  check(position, noise.position, "position");
  check(turn, noise.angle, "orientation");
  check(velocity, noise.velocity, "velocity");
  check(angular, noise.angular_velocity, "angular velocity");
  check(joint, noise.angle, "joints");
  check(speed, noise.angular_velocity, "joint velocities");
  check(force, noise.force, "wrench");
}

TEST(SimulatedRobot, IsSeededAndResettable) {
  MeasurementNoise noise = some_noise();
  SimulatedRobot first = robot_with(noise), second = robot_with(noise);
  noise.seed = 2;
  SimulatedRobot other = robot_with(noise);
  EXPECT_EQ(measured(first).q, measured(second).q);
  EXPECT_NE(measured(first).q, measured(other).q);
  const VectorXd at_start = measured(first).q;
  first.wait();
  EXPECT_NE(measured(first).q, at_start);
  const StillPlant still;
  first.reset(still.state());
  EXPECT_EQ(measured(first).q, at_start);
}

TEST(SimulatedRobot, IsExactWithoutNoise) {
  SimulatedRobot robot = robot_with({});
  robot.wait();
  const StillPlant still;
  EXPECT_EQ(measured(robot).q, still.state().q);
  EXPECT_EQ(measured(robot).base.matrix(), still.state().base.matrix());
  EXPECT_EQ(robot.read().ideal->left.wrench, still.contact(Side::left).wrench);
}

TEST(SimulatedRobot, DelaysTorquesByWholeTicks) {
  for (const int delay : {0, 1, 3}) {
    std::vector<double> acting;
    SimulatedRobot robot = robot_with({}, delay, &acting);
    for (int k = 0; k < 8; ++k) {
      robot.write({VectorXd::Constant(joints, 10.0 + k)});
      robot.wait();
      robot.wait();  // two steps of the engine per tick
    }
    ASSERT_EQ(acting.size(), 16u);
    for (int k = 0; k < 8; ++k) {
      const double expected = 10.0 + std::max(0, k - delay);  // the first command holds until then
      EXPECT_EQ(acting[2 * k], expected) << "delay " << delay << ", tick " << k;
      EXPECT_EQ(acting[2 * k + 1], expected) << "delay " << delay << ", tick " << k;
    }
  }
}

// The plant turns with 0.25 rad/s.
TEST(SimulatedRobot, MotorsKeepTheirTorqueSpeedLine) {
  std::vector<double> acting;
  FloatingRobot body = still_body();
  for (FloatingRobot::Body& b : body.bodies) {
    b.effort = 20.0;
    b.drive.no_load_speed = 1.0;
  }
  SimulatedRobot robot(std::make_unique<StillPlant>(&acting), body, {}, 0.002);
  for (const double wanted : {10.0, 30.0, -30.0}) {
    robot.write({VectorXd::Constant(joints, wanted)});
    robot.wait();
  }
  EXPECT_EQ(acting, (std::vector<double>{10.0, 15.0, -20.0}));
}

TEST(SimulatedRobot, DrivesActAsSpringsAndDampers) {
  std::vector<double> acting;
  SimulatedRobot robot(std::make_unique<StillPlant>(&acting), still_body(), {}, 0.002);
  const auto all = [](double value) { return VectorXd::Constant(joints, value); };
  // Joint 0 is at -1 rad. The position of the command moves with 2 rad/s.
  robot.write({all(3.0), all(-0.9), all(2.0), all(10.0), all(4.0)});
  robot.wait();
  robot.wait();
  EXPECT_NEAR(acting[0], 3.0 + 10.0 * 0.1 + 4.0 * 1.75, 1e-12);
  EXPECT_NEAR(acting[1], acting[0] + 10.0 * 2.0 * 0.001, 1e-12);
}

TEST(SimulatedRobot, RejectsInvalidOptions) {
  MeasurementNoise noise;
  noise.angle = -1.0;
  EXPECT_THROW(robot_with(noise), DefinitionError);
  EXPECT_THROW(robot_with({}, -1), DefinitionError);
}

TEST(MassError, ScalesMassesAndInertiasOnly) {
  FloatingRobot robot;
  FloatingRobot::Body body;
  body.mass = 2.0;
  body.com << 0.1, 0.2, 0.3;
  body.inertia.setIdentity();
  robot.bodies = {body, body};
  robot.total_mass = 4.0;
  const FloatingRobot heavier = with_masses_scaled(robot, 1.25);
  EXPECT_EQ(heavier.total_mass, 5.0);
  EXPECT_EQ(heavier.bodies[1].mass, 2.5);
  EXPECT_EQ(heavier.bodies[1].inertia(2, 2), 1.25);
  EXPECT_EQ(heavier.bodies[1].com, body.com);
}

TEST(FloatingRobot, IsShifted) {
  FloatingRobot::Body body;
  body.mass = 2.0;
  FloatingRobot robot;
  robot.bodies = {body, body};
  robot.total_mass = 4.0;
  const FloatingRobot shifted = with_com_shifted(robot, {0.01, 0.0, -0.02});
  // Half of the mass moves by twice the distance.
  EXPECT_LT((shifted.bodies[0].com - body.com - Vec<double, 3>(0.02, 0.0, -0.04)).norm(), 1e-15);
  EXPECT_EQ(shifted.bodies[1].com, body.com);
}

}  // namespace
}  // namespace saltus::robots::walking
