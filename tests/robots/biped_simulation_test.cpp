// The controller of a biped in closed loop with a simulated robot.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "saltus/core/error.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/levelled.hpp"
#include "saltus/robots/simulation/simulate.hpp"
#include "saltus/robots/simulation/simulated_robot.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "tests/app/support.hpp"
#include "tests/robots/fixed_steps.hpp"
#include "tests/robots/recorded_run.hpp"
#include "tests/robots/synthetic_balance.hpp"

namespace saltus::robots::walking {
namespace {

class BipedSimulation : public testing::Test {
 protected:
  SimulatedRobot simulated(const PlantSettings& settings) const {
    SimulatedRobot robot(make_dart_plant(biped.robot, settings.engine), biped.robot, settings,
                         biped.options().control_period);
    robot.reset(biped.start);
    return robot;
  }

  SyntheticBalance biped;
};

// If SALTUS_RECORD_RUN names a file, the test writes the recording there. Otherwise the recording
// must match the present simulation: the first samples to all digits, later ones approximately,
// because another version of the engine amplifies differences.
TEST_F(BipedSimulation, ReproducesTheRecordedRun) {
  PlantSettings settings;
  settings.sensors = PlantSettings::Sensors::measured;
  SimulatedRobot robot = simulated(settings);
  BalanceController controller =
      biped.controller(make_dart_dynamics(biped.robot), biped.sensor_estimator());
  controller.start(biped.start, robot.read());
  std::string text;
  std::vector<RecordedLine> now;
  for (int k = 0; k < 250; ++k) {
    const Robot::Commands& commands = controller.update(robot.read());
    now.push_back({robot.read(), controller.last().has_landed, commands.torques});
    text += to_csv(now.back());
    robot.write(commands);
    ASSERT_EQ(robot.wait(), "");
  }
  if (const char* file = std::getenv("SALTUS_RECORD_RUN")) std::ofstream(file) << text;
  const std::vector<RecordedLine> lines =
      read_recorded_run(SALTUS_RECORDED_RUN, biped.robot.joints());
  ASSERT_EQ(lines.size(), now.size());
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const double tolerance = k < 50 ? 1e-6 : 1e-2;  // rad
    EXPECT_LT((lines[k].readings.q - now[k].readings.q).norm(), tolerance) << k;
  }
}

// The planner's wrenches have level axes. A tilted sole must not rotate them.
TEST_F(BipedSimulation, RotatesWrenchesIntoTiltedSoles) {
  // 20 N s; the robot falls.
  const Pulse push{20.0, Vec<double, 3>(0.0, -1.0, 0.0), 0.02, 0.1};
  SimulatedRobot robot = simulated({});
  robot.push_by({&push, 1}, {biped.robot.body_index("trunk"), Eigen::Isometry3d::Identity()});
  BalanceController controller =
      biped.controller(make_dart_dynamics(biped.robot), make_ideal_estimator());
  controller.start(biped.start, robot.read());
  double tilt = 0.0;
  for (int k = 0; k < 1000; ++k) {
    robot.write(controller.update(robot.read()));
    const double t = robot.read().time;
    if (controller.last().has_controlled) {
      const SoleFrame frame = controller.centroidal_estimate().left_sole;
      const Mat<double, 3, 3> sole = frame.rotation, level = levelled(frame).rotation;
      tilt = std::max(tilt, std::acos(std::min(1.0, sole(2, 2))));
      const Vec<double, 6> wanted = controller.planner().wrenches(t).head<6>();
      const Vec<double, 6> planned = controller.tasks().wrenches.head<6>();
      for (const int part : {0, 3})
        ASSERT_LT((sole * planned.segment<3>(part) - level * wanted.segment<3>(part)).norm(), 1e-9)
            << t;
      const BalancePlanner::Estimate estimate = controller.centroidal_estimate();
      const Vec<double, 3> expected =
          level * estimate.applied.head<3>() +
          levelled(estimate.right_sole).rotation * estimate.applied.segment<3>(6);
      ASSERT_LT((expected - estimate.contact_force).norm(), 1e-9) << t;
    }
    ASSERT_EQ(robot.wait(), "");
  }
  EXPECT_GT(tilt, 0.05);  // rad
}

// A synthetic biped, read from its files, with the capture-point controller.
class SyntheticProblem : public testing::Test {
 protected:
  SyntheticProblem() {
    const SyntheticBiped biped;
    BipedSettings& settings = problem.settings();
    settings.robot.urdf = folder.file("robot.urdf", biped.urdf()).string();
    settings.robot.file = folder.file("robot.yaml", biped.yaml()).string();
    settings.scene.stance = Stance::left;
    settings.plant.choice = PlantSettings::Choice::dart;
    settings.push.link = "trunk";
    robot = robot_of(settings);
  }

  TemporaryFolder folder;
  FixedSteps problem{{}, 0.05};
  RobotDescription robot;
};

// Control period 2 ms, engine step 1 ms, planner period 10 ms.
TEST_F(SyntheticProblem, SamplesMatchTheWholeBodyController) {
  const RunLog log = simulate(problem, robot);
  ASSERT_EQ(log.samples.size(), 25u);
  ASSERT_EQ(log.body.size(), 25u);
  ASSERT_EQ(log.ticks.size(), 5u);
  for (std::size_t k = 0; k < 25; ++k)
    EXPECT_DOUBLE_EQ(log.samples[k].time, 0.002 * static_cast<double>(k));
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_DOUBLE_EQ(log.ticks[k].time, 0.01 * static_cast<double>(k));
  EXPECT_EQ(log.control_calls, 25);
}

// Hides a SimulatedRobot from its users and forwards all calls to it.
class RemoteRobot final : public Robot {
 public:
  explicit RemoteRobot(SimulatedRobot& robot) : robot_(robot) {}
  const Robot::Readings& read() const override { return robot_.read(); }
  void write(const Robot::Commands& commands) override { robot_.write(commands); }
  std::string wait() override { return robot_.wait(); }
  double period() const override { return robot_.period(); }
  std::string name() const override { return "remote"; }

 private:
  SimulatedRobot& robot_;
};

// A user's program drives any Robot with the torques of simulate(), bit for bit.
TEST_F(SyntheticProblem, AnyRobotGetsTheTorquesOfTheSimulation) {
  BipedSettings& settings = problem.settings();
  settings.robot.mass_error = 0.1;
  for (const PlantSettings::Sensors sensors :
       {PlantSettings::Sensors::ideal, PlantSettings::Sensors::measured}) {
    settings.plant.sensors = sensors;
    const RunLog log = simulate(problem, robot);

    const UrdfModel model = UrdfModel::read(urdf_of_body(settings.robot));
    const FloatingRobot real = with_drives_scaled(floating_robot(model, robot), {});
    const FloatingRobot body = with_masses_scaled(real, 1.1);
    const WholeBodyState start = standing_state(real, model, robot, problem.posture(robot));
    SimulatedRobot simulated(make_dart_plant(real, settings.plant.engine), body, settings.plant,
                             settings.control.period);
    simulated.reset(start);
    RemoteRobot remote(simulated);
    BalanceController controller =
        make_balance_controller(problem, robot, body, make_dart_dynamics(body),
                                initial_scene(problem, robot), remote.period());
    controller.start(start, remote.read());
    std::size_t compared = 0;
    for (int k = 0; k < 50; ++k) {
      const Robot::Commands& commands = controller.update(remote.read());
      if (controller.last().has_controlled) {
        ASSERT_LT(compared, log.body.size());
        EXPECT_EQ(commands.torques, log.body[compared++].torques) << k;
      }
      remote.write(commands);
      ASSERT_EQ(remote.wait(), "");
    }
    EXPECT_EQ(compared, log.body.size());
  }
}

// The recorded impulse is exact for any length and start of the push between two samples.
TEST_F(SyntheticProblem, SampledPushHasItsImpulse) {
  problem.settings().control.period = 0.005;
  for (const PlantSettings::Choice plant :
       {PlantSettings::Choice::dart, PlantSettings::Choice::centroidal})
    for (const double start : {0.020, 0.021})
      for (const double duration : {0.001, 0.003}) {
        problem.settings().plant.choice = plant;
        Push push = problem.settings().push;
        push.start = start;
        push.duration = duration;
        problem.all = {push};
        const RunLog log = simulate(problem, robot);
        Vec<double, 3> impulse = Vec<double, 3>::Zero();
        for (std::size_t i = 0; i + 1 < log.samples.size(); ++i)
          impulse += log.samples[i].push * (log.samples[i + 1].time - log.samples[i].time);
        EXPECT_LT((impulse - push.impulse * push.direction).norm(), 1e-9)
            << start << " s, " << duration << " s";
      }
}

// No foot may initially be on the ground's step.
TEST_F(SyntheticProblem, RejectsAGroundStepUnderAFoot) {
  const double beside = std::abs(initial_scene(problem, robot).swing.position[1]);
  Plant::Ground& ground = problem.settings().plant.engine.ground;
  ground.height = 0.03;
  ground.edge = beside;
  EXPECT_THROW(simulate(problem, robot), InputError);
  ground.edge = beside + 0.2;
  EXPECT_NO_THROW(simulate(problem, robot));
  ground.edge = beside;
  ground.height = -0.03;  // below the foot in the air
  EXPECT_NO_THROW(simulate(problem, robot));
}

// On two feet, the lever arms divide the weight. On one foot, that foot carries all of it.
TEST(Scene, FootLoadsCarryAStandingBody) {
  Scene scene;
  scene.swing = flat_sole({0.0, -0.2, 0.0});
  const double weight = 30.0 * standard_gravity;
  const Vec<double, 3> com(0.01, -0.05, 0.5);
  EXPECT_EQ(scene.standing_wrenches(30.0, com)[2], weight);
  scene.two_feet = true;
  const Vec<double, 12> both = scene.standing_wrenches(30.0, com);
  EXPECT_NEAR(both[2], 0.75 * weight, 1e-9);
  EXPECT_NEAR(both[8], 0.25 * weight, 1e-9);
  scene.stand_on(Side::right);
  EXPECT_LT((scene.standing_wrenches(30.0, com) - both).norm(), 1e-9);
}

}  // namespace
}  // namespace saltus::robots::walking
