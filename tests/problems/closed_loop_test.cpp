// iCub recovers with the step, and only with the step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/icub/icub.hpp"
#include "tests/problems/push_recovery_run.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"

namespace saltus::push_recovery {
namespace {

// An early push keeps the runs short; all other settings are defaults.
Config pushed_by(double impulse) {
  Config config;
  config.push.impulse = impulse;
  config.push.start = 0.1;
  config.pictures = false;
  return config;
}

struct Outcome {
  RunLog log;
  Verdict verdict;
};

Outcome run(const Config& config) {
  Outcome outcome{simulate(config, icub()), {}};
  outcome.verdict = judge(config, outcome.log);
  return outcome;
}

void expect_every_solve_optimal(const RunLog& log) {
  for (const LoopLog::Tick& tick : log.ticks) {
    ASSERT_EQ(tick.status, SolveStatus::optimal) << tick.time << ": " << tick.message;
    // Our own residual. The solver scales its tolerance of 1e-8 differently.
    ASSERT_LT(tick.kkt, 1e-6) << tick.time;
  }
}

class RecoveryWithAStep : public ::testing::TestWithParam<double> {};

TEST_P(RecoveryWithAStep, SucceedsAfterAPush) {
  const Config config = pushed_by(GetParam());
  const Outcome outcome = run(config);
  EXPECT_TRUE(outcome.verdict.recovered) << outcome.verdict.reason;
  EXPECT_NEAR(outcome.log.touchdown, config.push.start + config.step.duration, 1e-9);
  expect_every_solve_optimal(outcome.log);
}

INSTANTIATE_TEST_SUITE_P(Impulses, RecoveryWithAStep, ::testing::Values(6.0, 8.0));

TEST(ClosedLoop, EightNewtonSecondsWithoutAStepIsAFall) {
  Config config = pushed_by(8.0);
  config.step.allowed = false;
  const Outcome outcome = run(config);
  EXPECT_FALSE(outcome.verdict.recovered);
  EXPECT_TRUE(outcome.log.stopped_early);
  EXPECT_EQ(outcome.log.touchdown, infinity);
  EXPECT_NE(outcome.verdict.reason.find("fell"), std::string::npos) << outcome.verdict.reason;
  expect_every_solve_optimal(outcome.log);  // a fall is not a failure of the solver
}

TEST(ClosedLoop, LandingMayFallBetweenTicks) {
  Outcome last;
  for (const double late : {0.0, 0.001, 0.0037, 0.009999}) {
    Config config = pushed_by(7.0);
    config.step.duration += late;
    Outcome outcome = run(config);
    ASSERT_TRUE(outcome.verdict.recovered) << late << ": " << outcome.verdict.reason;
    EXPECT_NEAR(outcome.log.touchdown, config.push.start + config.step.duration, 1e-9);
    if (late > 0.0) {
      // A delay of a few milliseconds changes the motion only slightly. The predicted place of the
      // foot shifts by omega x delay x distance to the sole's edge, 6.3 ms x 4.2 / s x 0.2 m = 5 mm
      // at most. The target shifts by half of that.
      EXPECT_NEAR(outcome.verdict.angular_momentum_max, last.verdict.angular_momentum_max, 0.05);
      EXPECT_LT(
          (outcome.log.samples.back().gamma.head<3>() - last.log.samples.back().gamma.head<3>())
              .norm(),
          5e-3);
      EXPECT_NEAR(outcome.verdict.final_com_error, last.verdict.final_com_error, 1e-3);
    }
    last = std::move(outcome);
  }
}

// Signs of a mirrored state or contact wrench, (force-like | torque-like) each.
const Vec<double, 3> image(1.0, -1.0, 1.0), axial_image(-1.0, 1.0, -1.0);

TEST(ClosedLoop, RightStanceIsTheMirrorImageOfLeftStance) {
  // In m, m/s, Nms; and in N, Nm. The two programs order rows and inputs differently, so ticks
  // agree to the solver's tolerance only; measured are 2e-7 and 1e-4.
  constexpr double same_motion = 1e-6, same_force = 1e-3;
  struct Case {
    BipedSettings::Controller controller;
    Step::Placement placement;
  };
  for (const Case& c :
       {Case{BipedSettings::Controller::mpc, Step::Placement::predicted},
        Case{BipedSettings::Controller::mpc, Step::Placement::fixed},
        Case{BipedSettings::Controller::capture_point, Step::Placement::predicted}}) {
    Config config = pushed_by(6.0);
    config.push.direction = Vec<double, 3>(0.3, -1.0, 0.0);
    config.controller = c.controller;
    config.step.placement = c.placement;
    const Outcome left = run(config);
    config.scene.stance = robots::Stance::right;
    config.push.direction[1] *= -1.0;
    const Outcome right = run(config);
    EXPECT_TRUE(left.verdict.recovered) << left.verdict.reason;
    EXPECT_TRUE(right.verdict.recovered) << right.verdict.reason;
    EXPECT_EQ(left.log.touchdown, right.log.touchdown);
    ASSERT_EQ(left.log.samples.size(), right.log.samples.size());
    double motion = 0.0, force = 0.0;
    for (std::size_t i = 0; i < left.log.samples.size(); ++i) {
      const BipedSample &a = left.log.samples[i], &b = right.log.samples[i];
      Vec<double, 9> gamma;
      gamma << image, image, axial_image;
      Vec<double, 6> wrench;
      wrench << image, axial_image;
      motion = std::max(motion, (a.gamma - gamma.cwiseProduct(b.gamma)).cwiseAbs().maxCoeff());
      for (const int foot : {0, 6})
        force = std::max(force, (a.wrenches.segment<6>(foot) -
                                 wrench.cwiseProduct(b.wrenches.segment<6>(6 - foot)))
                                    .cwiseAbs()
                                    .maxCoeff());
    }
    EXPECT_LT(motion, same_motion);
    EXPECT_LT(force, same_force);
  }
}

TEST(ClosedLoop, SmallPushIsRecoveredWithoutAStep) {
  const Outcome outcome = run(pushed_by(2.0));
  EXPECT_TRUE(outcome.verdict.recovered) << outcome.verdict.reason;
  EXPECT_EQ(outcome.log.touchdown, infinity);
}

TEST(ClosedLoop, AllSolversFindTheSameOptimumInEveryTick) {
  const Config config = pushed_by(6.0);
  const RunLog log = run(config).log;
  ASSERT_LT(log.touchdown, infinity);
  const robots::RobotDescription robot = icub();
  std::vector<std::unique_ptr<Planner>> planners;
  for (const SolverChoice solver :
       {SolverChoice::riccati, SolverChoice::sparse, SolverChoice::ipopt}) {
    Config c = config;
    c.planner.solver = solver;
    planners.push_back(make_mpc(c, robot, log.final_scene));
  }
  // During push, swing and landing. The planned inputs are not applied.
  Vec<double, 12> applied = log.samples.front().wrenches;
  const Schedule contacts = one_foot_then_two(log.touchdown);
  std::size_t tick = 0;
  for (const BipedSample& s : log.samples) {
    if (s.time > log.touchdown + 0.3 || tick == log.ticks.size()) break;
    if (s.time < log.ticks[tick].time - same_instant) {
      applied = s.wrenches;
      continue;
    }
    Planner::Measurement measured{.time = s.time, .gamma = s.gamma, .applied = applied};
    measured.right_bore = s.two_feet() && s.time > log.touchdown + same_instant;
    measured.contact_force = applied.head<3>() + applied.segment<3>(6);
    std::vector<double> costs;
    for (const auto& planner : planners) {
      const ControlTick& t = planner->tick(measured, log.final_scene, contacts);
      ASSERT_EQ(t.provenance, Provenance::optimal) << s.time;
      const Solution plan = planner->controller().report();
      EXPECT_LT(plan.kkt.scaled(), 1e-7) << s.time;
      costs.push_back(plan.cost);
    }
    for (const double cost : costs) EXPECT_NEAR(cost, costs.front(), 1e-7 * cost) << s.time;
    applied = s.wrenches;
    ++tick;
  }
  EXPECT_GT(tick, 90u);
}

// One tick in five has no time to solve, up to five consecutive ones.
TEST(ClosedLoop, RecoversWithEveryFifthTickDenied) {
  for (const int seed : {1, 2, 3}) {
    Config config = pushed_by(6.0);
    config.planner.missed_fraction = 0.2;
    config.planner.missed_seed = seed;
    const Outcome outcome = run(config);
    EXPECT_TRUE(outcome.verdict.recovered) << seed << ": " << outcome.verdict.reason;
    long missed = 0;
    for (const LoopLog::Tick& t : outcome.log.ticks)
      missed += t.status == SolveStatus::time_limit ? 1 : 0;
    const double fraction =
        static_cast<double>(missed) / static_cast<double>(outcome.log.ticks.size());
    EXPECT_NEAR(fraction, 0.2, 0.06) << seed;
    const LoopStatistics& loop = outcome.log.statistics;
    EXPECT_EQ(loop.all().count(), static_cast<long>(outcome.log.ticks.size()));
    EXPECT_EQ(loop.count(Provenance::feasible) + loop.count(Provenance::shifted), missed);
    EXPECT_EQ(loop.count(Provenance::fallback), 0);
  }
}

TEST(ClosedLoop, PlannerTickDoesNotAllocate) {
  const Config config = pushed_by(6.0);
  const robots::RobotDescription robot = icub();
  for (const SolverChoice solver : {SolverChoice::riccati, SolverChoice::sparse}) {
    Config c = config;
    c.planner.solver = solver;
    Scene scene = simulate(config, robot).final_scene;
    scene.two_feet = true;
    const auto planner = make_mpc(c, robot, scene);
    Planner::Measurement measured;
    measured.gamma << robot.default_posture().com, Vec<double, 6>::Zero();
    measured.applied[2] = measured.contact_force[2] = robot.mass * 9.81;
    scene.target = robots::walking::SceneSettings::Target::centroid;
    const Schedule early = one_foot_then_two(0.1), late = one_foot_then_two(0.1034);
    planner->tick(measured, scene, early);
    const testing::AllocationCount count;
    long optimal = 0;
    for (int k = 1; k < 20; ++k) {
      measured.time = 0.01 * k;
      measured.gamma[4] = -1e-3 * k;
      scene.stance_foot.x.upper -= 1e-4;  // estimates change in every tick
      scene.swing.position[1] -= 1e-4;
      const ControlTick& t = planner->tick(measured, scene, late);
      optimal += t.provenance == Provenance::optimal ? 1 : 0;
      measured.applied = t.input[0].input();
      measured.contact_force = measured.applied.head<3>() + measured.applied.segment<3>(6);
    }
    EXPECT_EQ(count.made(), 0) << name_of(solver);
    EXPECT_EQ(optimal, 19) << name_of(solver);
  }
}

// On the left foot, or mirrored.
Scene on_one_foot(robots::Side side = robots::Side::left) {
  const robots::FootRectangle left{between(-0.05, 0.1), between(-0.03, 0.04)};
  Scene scene;
  scene.side = side;
  scene.stance_foot = side == robots::Side::left ? left : left.mirrored();
  scene.swing_foot = scene.stance_foot.mirrored();
  return scene;
}

TEST(StepLogic, TriggerIsThePushOrTheCapturePoint) {
  for (const Step::Trigger trigger : {Step::Trigger::push, Step::Trigger::icp}) {
    Step options;
    options.trigger = trigger;
    StepLogic logic(options, 1.0, on_one_foot());
    logic.update(1.04, {0.0, -0.02}, 4.2);  // still over the sole
    EXPECT_FALSE(logic.is_stepping());
    logic.update(1.05, {0.0, -0.04}, 4.2);
    ASSERT_TRUE(logic.is_stepping());
    EXPECT_DOUBLE_EQ(logic.landing_time(), trigger == Step::Trigger::push ? 1.6 : 1.65);
  }
}

TEST(StepLogic, PlaceIsThePredictedCapturePointWithinReach) {
  StepLogic logic(Step{}, 1.0, on_one_foot());
  const double omega = 4.2;
  logic.update(1.1, {0.02, -0.05}, omega);
  ASSERT_TRUE(logic.is_decided());
  EXPECT_NEAR(logic.place()[0], 0.02, 1e-12);  // inside the sole fore and aft: nothing diverges
  EXPECT_NEAR(logic.place()[1], -0.03 - 0.02 * std::exp(omega * 0.5), 1e-12);
  logic.update(1.2, {0.02, -0.3}, omega);
  EXPECT_NEAR(logic.place()[1], -0.03 - 0.02 * std::exp(omega * 0.5), 1e-12);

  StepLogic far(Step{}, 1.0, on_one_foot());
  far.update(1.1, {0.2, -0.2}, omega);
  EXPECT_DOUBLE_EQ(far.place()[0], 0.25);
  EXPECT_DOUBLE_EQ(far.place()[1], -0.30);
}

TEST(StepLogic, PlacesPointAwayFromTheStanceFoot) {
  for (const Step::Placement placement : {Step::Placement::fixed, Step::Placement::predicted})
    for (const double y : {-0.035, -0.05, -0.2}) {
      Step options;
      options.placement = placement;
      StepLogic a(options, 1.0, on_one_foot());
      StepLogic b(options, 1.0, on_one_foot(robots::Side::right));
      a.update(1.1, {0.02, y}, 4.2);
      b.update(1.1, {0.02, -y}, 4.2);
      EXPECT_LT(a.place()[1], -0.1);
      EXPECT_EQ(a.place()[0], b.place()[0]);
      EXPECT_EQ(a.place()[1], -b.place()[1]);
    }
}

// For each place where the capture point leaves the sole, a step of the right foot either catches
// the robot or has no effect.
TEST(StepLogic, StepsOnlyIfHelpfulOnRequest) {
  Step options;
  options.decide = Step::Decision::if_it_helps;
  const auto steps_to = [&options](double x, double y) {
    StepLogic logic(options, 1.0, on_one_foot());
    logic.update(1.1, {x, y}, 4.2);
    return logic.is_stepping();
  };
  EXPECT_TRUE(steps_to(0.0, -0.04));     // right
  EXPECT_TRUE(steps_to(0.12, 0.0));      // forward
  EXPECT_TRUE(steps_to(-0.06, -0.01));   // back
  EXPECT_FALSE(steps_to(0.0, 0.05));     // left
  EXPECT_FALSE(steps_to(0.08, 0.05));    // by the left edge of the sole
  EXPECT_FALSE(steps_to(-0.04, 0.045));  // the same, behind
  options.decide = Step::Decision::always;
  EXPECT_TRUE(steps_to(0.0, 0.05));
}

TEST(StepLogic, LateHelpfulStepCountsFromItsDecision) {
  Step options;
  options.decide = Step::Decision::if_it_helps;
  StepLogic logic(options, 1.0, on_one_foot());
  logic.update(1.05, {0.0, 0.045}, 4.2);
  EXPECT_FALSE(logic.is_stepping());
  logic.update(1.15, {0.0, -0.04}, 4.2);
  ASSERT_TRUE(logic.is_stepping());
  EXPECT_DOUBLE_EQ(logic.landing_time(), 1.75);
}

// A long push is known only after its end, not 0.1 s after its start.
TEST(StepLogic, PlaceMovesUntilShortlyBeforeTheLandingOnRequest) {
  Step options;
  options.decision_lead = 0.1;
  StepLogic logic(options, 1.0, on_one_foot());
  logic.update(1.1, {0.0, -0.035}, 4.2);
  ASSERT_TRUE(logic.is_stepping());
  EXPECT_FALSE(logic.is_decided());
  const double early = logic.place()[1];
  logic.update(1.4, {0.0, -0.14}, 4.2);
  EXPECT_LT(logic.place()[1], early - 0.05);
  EXPECT_FALSE(logic.is_decided());
  logic.update(1.5, {0.0, -0.14}, 4.2);
  EXPECT_TRUE(logic.is_decided());
}

std::string complaint_about(const std::string& text) {
  Config config;
  Settings settings;
  declare_settings(settings, config);
  return error_of<InputError>([&] { settings.apply({parse_set_argument(text)}); }, "no complaint");
}

// Earlier versions ignored such pushes and the run "recovered", or the run did not end.
TEST(Settings, RejectsImpossiblePushesAndTimes) {
  for (const char* text :
       {"push.duration=1e-7", "push.duration=1e300", "push.direction=[1e308, 1e308, 0]",
        "push.direction=[0, 1e200, 0]", "push.direction=[0, 1e-200, 0]", "push.start=1e9",
        "push.impulse=1e300", "step.duration=1e9", "step.duration=1e-9", "simulator.step_s=1e-9"}) {
    const std::string key = std::string(text).substr(0, std::string(text).find('='));
    EXPECT_NE(complaint_about(text).find(key + (key == "push.direction" ? "" : "' must be")),
              std::string::npos)
        << complaint_about(text);
  }
  EXPECT_EQ(complaint_about("push.direction=[0, 30, 0]"), "no complaint");
}

TEST(Settings, RejectsInsufficientNormalForces) {
  Config config;
  config.contact.normal_force_min = 200.0;
  EXPECT_THROW(robot_of(config), InputError);
  config.contact = {};
  config.contact.normal_force_max = 300.0;
  EXPECT_THROW(robot_of(config), InputError);
  config.contact = {};
  EXPECT_NO_THROW(robot_of(config));
}

// An observer may end the run. The verdict then uses the recorded part.
TEST(ClosedLoop, InterruptedRunKeepsItsResults) {
  Config config;
  config.push.start = 0.1;
  const robots::RobotDescription robot = robot_of(config);
  const RunLog log = walking::simulate(PushRecovery(config), robot,
                                       [](const LoopState& state) { return state.time < 0.2; });
  EXPECT_TRUE(log.interrupted);
  EXPECT_NEAR(log.samples.back().time, 0.2, 0.02);
  EXPECT_EQ(log.ticks.size(), 21u);
  const Verdict verdict = judge(config, log);
  EXPECT_FALSE(verdict.recovered);
  EXPECT_EQ(verdict.reason.substr(0, 14), "interrupted at");
}

// Users' files contain these keys.
TEST(Settings, KeepsAllKeys) {
  Config config;
  Settings settings;
  declare_settings(settings, config);
  std::vector<std::string> keys = settings.keys();
  std::sort(keys.begin(), keys.end());
  std::istringstream words(
      "capture_point.after_landing_s contact.corners contact.edges contact.friction "
      "contact.fz_max contact.fz_min contact.torsional_friction_m control.period controller "
      "dart.collision dart.friction dart.lcp drive.backlash drive.damping drive.elasticity "
      "drive.friction drive.rotor_inertia "
      "drive.stiffness drive.torque_speed_line drives explain_limit_s joint_speed_limits "
      "model.com_error model.friction model.mass_error model.rotor_inertia "
      "momentum.angular_momentum "
      "momentum.linear_momentum momentum.wrench motor.bandwidth_hz motor.torque_rate "
      "mpc.capturing_momentum mpc.deadline_s mpc.intervals mpc.step_s pictures plant posture "
      "preset push.direction "
      "push.duration push.impulse push.link push.point push.random.apart_s push.random.impulse "
      "push.random.rate_hz push.random.seed push.random.until_s push.shape push.start pushes "
      "robot.config robot.urdf self_collision sensor.accelerometer.delay_s "
      "sensor.encoder.delay_s sensor.force_torque.delay_s sensor.gyroscope.delay_s "
      "sensor.rocking_walk sensor.seed "
      "sensor.standing_force sensor.velocity_lag_s sensors simulator.delay_ticks "
      "simulator.friction simulator.ground_ahead simulator.ground_edge_m "
      "simulator.ground_end_forward_m "
      "simulator.ground_end_side_m "
      "simulator.ground_friction simulator.ground_roughness_m simulator.ground_seed "
      "simulator.ground_sink_m "
      "simulator.ground_slope_forward simulator.ground_slope_side simulator.ground_step_m "
      "simulator.joint_friction_nms_per_rad "
      "simulator.step_s solver solver_tolerance stance step.bring_back step.decide "
      "step.decision_lead_s step.double_support_s step.duration step.fixed_place "
      "step.foot_speed step.forward_max step.lateral_max step.lateral_min step.lead_s "
      "step.longest_s step.momentum step.most step.placement step.planner step.reach "
      "step.shortest_s step.sole_margin step.torque step.usual_s step.weights stepping "
      "swing.apex swing.clearance_m swing.touch_speed_m_per_s target walk.clearance_m "
      "walk.double_support_s walk.duration walk.swing_s walk.velocity weights.capture_point "
      "weights.capture_point_softness "
      "weights.capture_point_standing weights.gamma weights.gamma_impact weights.wrench "
      "weights.wrench_change whole_body.angular_momentum whole_body.controller "
      "whole_body.estimate_mass whole_body.estimate_support "
      "whole_body.linear_momentum whole_body.posture whole_body.stance_damping "
      "whole_body.stance_stiffness whole_body.swing_foot whole_body.tipped_reserve "
      "whole_body.wrench");
  const std::vector<std::string> known{std::istream_iterator<std::string>(words), {}};
  EXPECT_EQ(keys, known);
}

// Preset and stance select the step planner and its related settings.
TEST(Settings, SelectsTheStepPlanner) {
  struct Case {
    std::vector<std::string> given;
    Step::Planner planner;
    double shortest, tipped_reserve;
  };
  const Case cases[] = {
      {{}, Step::Planner::formula, 0.3, 0.0},
      {{"plant=dart"}, Step::Planner::ocp, 0.25, 10.0},
      {{"plant=mujoco", "step.shortest_s=0.3"}, Step::Planner::ocp, 0.3, 10.0},
      {{"plant=dart", "preset=paper"}, Step::Planner::formula, 0.3, 0.0},
      {{"plant=dart", "step.planner=icp_formula"}, Step::Planner::formula, 0.3, 0.0},
      {{"plant=dart", "step.planner=reactive"}, Step::Planner::reactive, 0.3, 0.0},
      {{"stance=both", "step.planner=ocp"}, Step::Planner::ocp, 0.25, 10.0},
      {{"plant=dart", "stance=both"}, Step::Planner::reactive, 0.3, 0.0}};
  for (const Case& c : cases) {
    const Config config = config_of(c.given);
    EXPECT_EQ(config.step.planner, c.planner);
    EXPECT_EQ(config.planning.shortest, c.shortest);
    EXPECT_EQ(config.control.gains.tipped_reserve, c.tipped_reserve);
  }
  Config of_map;  // the map varies the step time of the formula
  of_map.step_times_are_given = true;
  apply({"plant=dart"}, of_map);
  EXPECT_EQ(of_map.step.planner, Step::Planner::formula);
}

TEST(Settings, PresetRobotHasRealDrives) {
  const Config robot = config_of({"plant=dart"});
  EXPECT_EQ(robot.drives, "real");
  EXPECT_EQ(robot.plant.drives.friction, 1.0);
  EXPECT_EQ(robot.scene.posture, "bent");
  EXPECT_EQ(config_of({"plant=mujoco", "drive.friction=2"}).plant.drives.friction, 2.0);
  EXPECT_EQ(config_of({"plant=dart", "stance=both"}).drives, "real");
  for (const std::vector<std::string>& words : {std::vector<std::string>{},
                                                {"plant=dart", "preset=paper"},
                                                {"plant=dart", "drives=ideal"}}) {
    const Config ideal = config_of(words);
    EXPECT_EQ(ideal.drives, "ideal");
    EXPECT_TRUE(ideal.plant.drives.is_ideal());
    EXPECT_EQ(ideal.scene.posture, "");
  }
}

// A file without drives gives ideal ones, and a robot without bent knees starts as it usually does.
TEST(Settings, DrivesDependOnTheFileOfTheRobot) {
  const auto of_robot = [](const std::string& joint) {
    const std::string file = ::testing::TempDir() + "robot.yaml";
    std::ofstream(file) << "name: Robo\nsource: made up\nmass: 30\nsoles: {left: ls, right: rs}\n"
                           "contact_plane_offset: 0\nbase: pelvis\njoints: {knee: {"
                        << joint
                        << "}}\nleft_foot: {x: [-0.05, 0.1], y: [-0.03, 0.04]}\n"
                           "right_foot: {x: [-0.05, 0.1], y: [-0.04, 0.03]}\n"
                           "postures: {stand: {stance: left, joints: {}}}\n";
    return config_of({"plant=dart", "robot.config=" + file});
  };
  EXPECT_EQ(of_robot("effort: 40").drives, "ideal");
  const Config geared = of_robot("rotor_inertia: 0.1, dry_friction: 2");
  EXPECT_EQ(geared.drives, "real");
  EXPECT_EQ(geared.scene.posture, "");
  EXPECT_EQ(config_of({"plant=dart", "robot.config=missing.yaml"}).drives, "ideal");
}

// Each case has a part of the expected message, which names a key.
TEST(Settings, RejectsContradictions) {
  const std::vector<std::pair<std::vector<std::string>, const char*>> cases{
      {{"step.planner=ocp", "step.usual_s=0.2"},
       "step.usual_s (0.2) must lie between step.shortest_s"},
      {{"step.planner=ocp", "stance=both", "walk.velocity=[0.1,0,0]", "walk.swing_s=5"},
       "walk.swing_s (5) must lie between step.shortest_s"},
      {{"step.shortest_s=1"}, "must be below step.longest_s"},
      {{"step.planner=reactive", "step.duration=0.2"},
       "step.shortest_s (0.3) exceeds step.duration"},
      {{"step.planner=ocp", "walk.double_support_s=0.05"},
       "walk.double_support_s (0.05) is shorter"},
      {{"step.planner=ocp", "walk.velocity=[1,0,0]"}, "; reduce walk.velocity or increase"},
      {{"walk.velocity=[0.1,0,0]"}, "walk.velocity needs step.planner=ocp"},
      {{"step.bring_back=true"}, "step.bring_back needs step.planner=ocp"},
      {{"plant=dart", "drives=ideal", "drive.elasticity=1"}, "set drive.rotor_inertia above 0"},
      {{"plant=dart", "drive.backlash=1"}, "set drive.elasticity above 0"},
      {{"simulator.ground_ahead=true", "simulator.ground_end_side_m=0.03"}, "has no end"},
      {{"pushes=2.45 3 90"}, "begins before the push at 2.4 s ends"}};
  for (const auto& [arguments, part] : cases)
    expect_error<InputError>([&words = arguments] { config_of(words); }, {part});
}

// These errors depend on the robot and appear at the start of a run.
TEST(Settings, RejectsEmptyFootReach) {
  Config config;
  config.step.planner = Step::Planner::ocp;
  config.planning.robot_reach = false;  // reach from the settings, with or without a URDF
  const robots::RobotDescription robot = robot_of(config);
  const auto complaint = [&robot](const Config& given) {
    return error_of<InputError>(
        [&] {
          const PushRecovery problem(given);
          problem.make_step_planner(robot, initial_scene(problem, robot));
        },
        "");
  };
  EXPECT_EQ(complaint(config), "");
  Config narrow = config;
  narrow.step.forward_max = 0.0;
  EXPECT_NE(complaint(narrow).find("leave no place for a foot"), std::string::npos);
  Config fast = config;
  fast.planning.velocity[0] = 0.7;
  EXPECT_NE(complaint(fast).find("beyond the reach of the legs"), std::string::npos);
}

TEST(Settings, RejectsAFixedPlaceAcrossTheStanceFoot) {
  Config config;
  Settings settings;
  declare_settings(settings, config);
  expect_error<InputError>(
      [&] { settings.apply({parse_set_argument("step.fixed_place=[0, -0.14]")}); },
      {"away from the stance sole"});
}

}  // namespace
}  // namespace saltus::push_recovery
