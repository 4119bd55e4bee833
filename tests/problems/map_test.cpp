// Survival maps: order of runs, skipped cells, resuming, invalid requests, and complete maps.
#include "problems/biped/survival/map.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <sstream>

#include "problems/biped/survival/map_file.hpp"
#include "problems/biped/survival/pendulum_bound.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/body_verdict.hpp"
#include "tests/app/support.hpp"
#include "tests/problems/push_recovery_run.hpp"
#include "tests/support/standing_bound.hpp"

namespace saltus::push_recovery {
namespace {

using Words = std::vector<std::string>;

// ---- the pendulum's bound ----

constexpr double forward = 0.0, left = 0.5 * std::numbers::pi, back = std::numbers::pi,
                 right = 1.5 * std::numbers::pi;  // rad

PendulumBound bound_of(const Config& config, const robots::RobotDescription& robot) {
  return pendulum_bound(config.push, config.step, config.scene, robot);
}

// The pendulum height of the published figures.
PendulumBound published() {
  PendulumBound bound = bound_of({}, icub());
  bound.height = 0.534;
  return bound;
}

TEST(PendulumBound, ReproducesThePublishedFigures) {
  const PendulumBound bound = published();
  EXPECT_NEAR(bound.largest_impulse(right, {}), 5.4, 0.05);
  EXPECT_NEAR(bound.largest_impulse(right, 0.6), 9.5, 0.05);  // foot at -0.30 m at most
  Config config;
  config.step.placement = Step::Placement::fixed;  // at -0.14 m
  PendulumBound fixed = bound_of(config, icub());
  fixed.height = 0.534;
  // Printed as 7.3; with the right sole's own edge, 0.041 m outside its origin, it is 7.40.
  EXPECT_NEAR(fixed.largest_impulse(right, 0.6), 7.3, 0.11);
}

TEST(PendulumBound, RightStanceIsTheMirrorImageOfLeftStance) {
  for (const Step::Placement placement : {Step::Placement::predicted, Step::Placement::fixed}) {
    Config config;
    config.step.placement = placement;
    const PendulumBound on_left = bound_of(config, icub());
    config.scene.stance = robots::Stance::right;
    const PendulumBound on_right = bound_of(config, icub());
    constexpr double rounding = 1e-9;  // N s
    for (const double angle : {0.1, 1.0, 2.0, 3.0, 4.0, 5.0}) {
      EXPECT_NEAR(on_left.largest_impulse(angle, 0.6), on_right.largest_impulse(-angle, 0.6),
                  rounding);
    }
  }
}

TEST(PendulumBound, AlongFootAxesMatchesTheOneDimensionalBound) {
  const PendulumBound bound = published();
  const auto along_axis = [&](double edge, double reach, double landing) {
    return robots::largest_impulse_with_step(reach, landing,
                                             {.mass = bound.mass,
                                              .height = bound.height,
                                              .distance_to_edge = edge,
                                              .duration = bound.push.duration});
  };
  constexpr double rounding = 1e-9;  // N s; also that of the cosine of a quarter turn
  for (const double landing : {0.3, 0.45, 0.6}) {
    // Distance from the stance sole's edge to the new sole's edge at its farthest place.
    EXPECT_NEAR(bound.largest_impulse(right, landing),
                along_axis(0.031, 0.30 + 0.041 - 0.031, landing), rounding);
    EXPECT_NEAR(bound.largest_impulse(forward, landing), along_axis(0.1065, 0.25, landing),
                rounding);
    EXPECT_NEAR(bound.largest_impulse(back, landing), along_axis(0.0535, 0.25, landing), rounding);
    // The right foot cannot step to the left, so a step has no effect.
    EXPECT_NEAR(bound.largest_impulse(left, landing), along_axis(0.041, 0.0, landing), rounding);
    EXPECT_NEAR(bound.largest_impulse(left, {}), along_axis(0.041, 0.0, landing), rounding);
  }
}

// Support function of a rectangle along a normal.
double support(const robots::FootRectangle& r, const robots::Point2& n,
               const robots::Point2& shift = robots::Point2(0.0, 0.0)) {
  return n.dot(shift) + std::max(n[0] * r.x.lower, n[0] * r.x.upper) +
         std::max(n[1] * r.y.lower, n[1] * r.y.upper);
}

// Check without polygons: a point is in a convex set if no normal separates them, and on its border
// if one touches. The support of a sum is the sum of supports, that of a hull their maximum.
TEST(PendulumBound, PushEndsOnTheSupportBorderInAnyDirection) {
  const PendulumBound bound = published();
  const double omega = std::sqrt(9.81 / bound.height);
  const double per_impulse = (1.0 - std::exp(-omega * bound.push.duration)) /
                             (bound.mass * omega * omega * bound.push.duration);
  for (const double landing : {0.3, 0.6}) {
    const double late = std::exp(-omega * landing);
    for (int i = 0; i < 32; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 32.0;
      const robots::Point2 end = bound.largest_impulse(angle, landing) * per_impulse *
                                 robots::Point2(std::cos(angle), std::sin(angle));
      double gap = infinity;
      constexpr int normals = 36000;
      for (int k = 0; k < normals; ++k) {
        const double at = 2.0 * std::numbers::pi * k / normals;
        const robots::Point2 n(std::cos(at), std::sin(at));
        double both = support(bound.stance_foot, n);
        for (const double x : {bound.reach_x.lower, bound.reach_x.upper})
          for (const double y : {bound.reach_y.lower, bound.reach_y.upper})
            both = std::max(both, support(bound.swing_foot, n, robots::Point2(x, y)));
        gap =
            std::min(gap, (1.0 - late) * support(bound.stance_foot, n) + late * both - n.dot(end));
      }
      // Tolerance: rounding, and the angle between normals times the length of a side.
      EXPECT_GT(gap, -1e-12) << angle;
      EXPECT_LT(gap, 1e-4) << angle;
    }
  }
}

TEST(PendulumBound, DependsOnThePushShape) {
  PendulumBound bound = published();
  const double constant = bound.largest_impulse(right, {});
  bound.push.shape = PulseShape::triangle;
  const double omega = std::sqrt(9.81 / bound.height), half = 0.5 * bound.push.duration;
  // A triangle is the convolution of a rectangle of half the length with itself: its mean decay is
  // the square.
  const double decay = std::pow((1.0 - std::exp(-omega * half)) / (omega * half), 2);
  EXPECT_NEAR(bound.largest_impulse(right, {}), bound.mass * omega * 0.031 / decay, 1e-8);
  // The variance about the same middle is T^2 / 24, and T^2 / 12 for the rectangle.
  const double spread = std::pow(omega * bound.push.duration, 2) / 48.0;
  constexpr double higher_orders = 1e-3;  // N s
  EXPECT_NEAR(bound.largest_impulse(right, {}), constant * (1.0 + spread), higher_orders);
}

// Settings of the planner that chooses its steps, with a rectangular reach.
Config stepping(robots::Stance stance, int most) {
  Config config;
  config.scene.stance = stance;
  if (stance == robots::Stance::both) config.scene.target = SceneSettings::Target::centroid;
  config.step.planner = Step::Planner::ocp;
  config.planning.robot_reach = false;
  config.planning.most_steps = most;
  return config;
}

PendulumBound bound_of_steps(robots::Stance stance, int most) {
  const Config config = stepping(stance, most);
  const robots::RobotDescription robot = icub();
  return pendulum_bound(config.push, config.step, config.scene, robot,
                        PushRecovery(config).step_bounds(robot));
}

TEST(PendulumBound, OneStepUsesTheShortestTime) {
  const PendulumBound bound = bound_of_steps(robots::Stance::left, 1);
  ASSERT_TRUE(bound.steps);
  EXPECT_EQ(bound.steps->shortest, 0.3);
  constexpr double rounding = 1e-9;  // N s
  for (int i = 0; i < 32; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 32.0;
    EXPECT_NEAR(bound.largest_impulse_in(angle, 0), bound.largest_impulse(angle, {}), rounding);
    EXPECT_NEAR(bound.largest_impulse_in(angle, 1), bound.largest_impulse(angle, 0.3), rounding);
    EXPECT_GE(bound.largest_impulse_in(angle, 2), bound.largest_impulse_in(angle, 1) - rounding);
  }
  // Each step gains at most e times the gain of the previous one.
  const double e = std::exp(-std::sqrt(9.81 / bound.height) * 0.3);
  const auto won = [&](int n) {
    return bound.largest_impulse_in(forward, n) - bound.largest_impulse_in(forward, n - 1);
  };
  EXPECT_GT(won(2), 1.0);
  EXPECT_NEAR(won(3), e * won(2), 1e-6);
  EXPECT_FALSE(PushRecovery(Config{}).step_bounds(icub()));  // the formula's time is a setting
}

// Along one axis these are the margins of Koolen et al.
TEST(Capturability, ForwardCaseMatchesTheOneDimensionalBound) {
  const robots::FootRectangle sole{between(-0.08, 0.08), between(-0.03, 0.03)};
  const robots::SteppingLimits limits{
      sole, sole, {{-0.3, 0.1}, {0.3, 0.1}, {0.3, 0.3}, {-0.3, 0.3}}, 0.35};
  constexpr double omega = 4.2, rounding = 1e-12;  // 1/s, m
  for (int steps = 0; steps <= 4; ++steps) {
    double farthest = 0.0;
    const robots::SupportPolygon set =
        robots::capturable(limits, robots::Side::right, steps, omega);
    for (const robots::Point2& corner : set.vertices()) farthest = std::max(farthest, corner[0]);
    EXPECT_NEAR(farthest, robots::capturability_margin(steps, {0.3, 0.35, 0.08}, omega), rounding);
  }
}

// Sideways, both feet on the ground resist more than the inner edge of one foot during the swing of
// the other. Forward, every step increases the bound.
TEST(PendulumBound, UsesTheHullOrAStepOfEitherFootOnTwoFeet) {
  const PendulumBound bound = bound_of_steps(robots::Stance::both, 1);
  ASSERT_TRUE(bound.other_foot);
  const double apart = -(*bound.other_foot)[1], omega = std::sqrt(9.81 / bound.height);
  const double per_metre = bound.mass * omega * (omega * bound.push.duration) /
                           (1.0 - std::exp(-omega * bound.push.duration));
  const double outer = 0.041, length = 0.16, step = 0.25;  // sole and its step, m
  constexpr double skew = 0.03;  // N s: in the posture the feet are not exactly side by side
  EXPECT_NEAR(bound.largest_impulse(right, {}), (0.5 * apart + outer) * per_metre, skew);
  EXPECT_NEAR(bound.largest_impulse(forward, {}), 0.5 * length * per_metre, skew);
  EXPECT_NEAR(bound.largest_impulse_in(right, 0), bound.largest_impulse(right, {}), skew);
  const double e = std::exp(-omega * bound.steps->shortest);
  EXPECT_NEAR(bound.largest_impulse_in(right, 1), bound.largest_impulse(right, {}), skew);
  EXPECT_NEAR(bound.largest_impulse_in(forward, 1), (0.5 * length + e * step) * per_metre, skew);
  for (int i = 0; i < 16; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 16.0;
    EXPECT_NEAR(bound.largest_impulse_in(angle, 2), bound.largest_impulse_in(-angle, 2), skew);
    EXPECT_GE(bound.largest_impulse_in(angle, 1), bound.largest_impulse(angle, {}) - skew);
  }
}

TEST(PendulumBound, RejectsInvalidValues) {
  PendulumBound bound = published();
  EXPECT_THROW(bound.largest_impulse(right, 0.05), DefinitionError);
  EXPECT_NO_THROW(bound.largest_impulse(right, bound.push.duration));  // lands as the push ends
  EXPECT_THROW(bound.largest_impulse(std::nan(""), {}), DefinitionError);
  bound.start = {0.0, 0.1};
  EXPECT_THROW(bound.largest_impulse(right, {}), DefinitionError);
  bound = published();
  bound.mass = 0.0;
  EXPECT_THROW(bound.largest_impulse(right, {}), DefinitionError);
}

// ---- results of a run ----

// Capture points at 0.02, 0.05 and 0.01 m along the push.
RunLog map_log() {
  RunLog log;
  for (const double x : {0.02, 0.05, 0.01}) {
    BipedSample s;
    s.capture_point << x, -7.0;
    log.samples.push_back(s);
  }
  for (const SolveStatus status :
       {SolveStatus::optimal, SolveStatus::time_limit, SolveStatus::infeasible}) {
    LoopLog::Tick tick;
    tick.status = status;
    log.ticks.push_back(tick);
  }
  return log;
}

TEST(MapRow, HasTheResultsOfTheRun) {
  Push push;
  push.direction = Vec<double, 3>(2.0, 0.0, 0.0);
  push.start = 0.5;
  const MapCell cell{MapController::mpc, 0.6, 0.0, 4.0};
  Verdict verdict;
  verdict.recovered = true;
  const MapRow stands = map_row(cell, 9.0, push, map_log(), verdict);
  EXPECT_EQ(stands.cell, cell);
  EXPECT_EQ(stands.bound, 9.0);
  EXPECT_EQ(stands.outcome, MapOutcome::recovered);
  EXPECT_EQ(stands.icp_furthest, 0.05);
  EXPECT_EQ(stands.failed_solves, 1);  // running out of time is not a failure
  EXPECT_FALSE(stands.stepped);
  EXPECT_TRUE(std::isnan(stands.icp_settling));
  EXPECT_TRUE(std::isnan(stands.touchdown));

  RunLog log = map_log();
  log.touchdown = 1.25;
  log.steps.resize(1);
  verdict.icp_settling = 0.75;
  verdict.angular_momentum_max = 2.0;
  verdict.com_height_min = 0.4;
  verdict.com_height_max = 0.6;
  verdict.final_com_error = 0.003;
  const MapRow steps = map_row(cell, 9.0, push, log, verdict);
  EXPECT_TRUE(steps.stepped);
  EXPECT_EQ(steps.touchdown, 0.75);
  EXPECT_EQ(steps.icp_settling, 0.75);
  EXPECT_EQ(steps.angular_momentum_max, 2.0);
  EXPECT_EQ(steps.com_height_min, 0.4);
  EXPECT_EQ(steps.com_height_max, 0.6);
  EXPECT_EQ(steps.final_com_error, 0.003);
}

TEST(MapRow, ReportsTheOutcome) {
  const auto outcome = [](MapController controller, const RunLog& log, const Verdict& verdict) {
    return map_row({controller, 0.0, 0.0, 4.0}, 9.0, {}, log, verdict).outcome;
  };
  Verdict verdict;
  verdict.fail("fell");
  EXPECT_EQ(outcome(MapController::mpc, map_log(), verdict), MapOutcome::not_recovered);
  verdict = {};
  verdict.recovered = true;
  RunLog failed = map_log();
  failed.numerical_failure = true;
  EXPECT_EQ(outcome(MapController::mpc, failed, verdict), MapOutcome::failed);
  failed = map_log();
  failed.control_calls = 100;
  failed.control_failures = 2;
  EXPECT_EQ(outcome(MapController::mpc, failed, verdict), MapOutcome::failed);
  // Without a step, a hop of a foot or a tilted base at the end is not a recovery.
  verdict.body = Verdict::Body{};
  EXPECT_EQ(outcome(MapController::none, map_log(), verdict), MapOutcome::recovered);
  verdict.body->feet_moved = standing_move;
  EXPECT_EQ(outcome(MapController::none, map_log(), verdict), MapOutcome::not_recovered);
  EXPECT_EQ(outcome(MapController::mpc, map_log(), verdict), MapOutcome::recovered);
  verdict.body->feet_moved = 0.0;
  verdict.body->tilt_end = standing_tilt;
  EXPECT_EQ(outcome(MapController::none, map_log(), verdict), MapOutcome::not_recovered);
}

// ---- the command line ----

MapRequest parse(const Words& words) {
  Config config;
  config.step_times_are_given = true;  // as the verb `map` sets it
  return parse_map_request(PushRecovery(config), words);
}

TEST(MapCommandLine, HasDefaults) {
  const MapRequest request = parse({});
  EXPECT_EQ(request.grid.directions.size(), 16u);
  EXPECT_EQ(request.grid.impulses.size(), 16u);
  EXPECT_EQ(request.grid.impulses.back(), 16.0);
  EXPECT_EQ(request.grid.step_times, (std::vector<double>{0.3, 0.45, 0.6}));
  EXPECT_EQ(request.grid.controllers.size(), 3u);
  EXPECT_FALSE(request.grid.all);
  EXPECT_EQ(request.out, "results/map_centroidal");
  EXPECT_GE(request.jobs, 1);
  EXPECT_EQ(parse({"--plant", "dart"}).out, "results/map_dart");
}

TEST(MapCommandLine, AcceptsAllOptions) {
  const MapRequest request =
      parse({"--plant=dart", "--set", "push.duration=0.2", "--directions", "8", "--impulses",
             "0.5:0.1:1", "--step-times", "0.6,0.3", "--controllers", "none,mpc", "--jobs=3",
             "--out", "here", "--all"});
  EXPECT_EQ(request.problem->settings().plant.choice, PlantSettings::Choice::dart);
  EXPECT_EQ(request.problem->settings().push.duration, 0.2);
  EXPECT_EQ(request.grid.directions.size(), 8u);
  ASSERT_EQ(request.grid.impulses.size(), 6u);
  EXPECT_DOUBLE_EQ(request.grid.impulses[5], 1.0);
  EXPECT_EQ(request.grid.step_times, (std::vector<double>{0.3, 0.6}));
  EXPECT_EQ(request.grid.controllers,
            (std::vector<MapController>{MapController::none, MapController::mpc}));
  EXPECT_EQ(request.jobs, 3);
  EXPECT_EQ(request.out, "here");
  EXPECT_TRUE(request.grid.all);
  EXPECT_EQ(parse({"--impulses", "4,2.5"}).grid.impulses, (std::vector<double>{2.5, 4.0}));
}

TEST(MapCommandLine, RejectsRandomPushes) {
  const auto random = [] {
    parse({"--set", "push.random.rate_hz=0.1", "--set", "push.random.until_s=60"});
  };
  EXPECT_TRUE(
      contains(complaint_of(random), "push.random.rate_hz: a map has one given push per cell"));
}

TEST(MapCommandLine, ReportsMistakes) {
  const auto complaint = [](const Words& words) { return complaint_of([&] { parse(words); }); };
  EXPECT_TRUE(contains(complaint({"--direction", "8"}), "did you mean '--directions'?"));
  EXPECT_TRUE(contains(complaint({"dart"}), "usage: map"));
  EXPECT_TRUE(contains(complaint({"--plant", "drat"}), "did you mean 'dart'"));
  EXPECT_TRUE(contains(complaint({"--directions", "0"}), "whole number from 1 to 360"));
  EXPECT_TRUE(contains(complaint({"--directions", "7.5"}), "whole number"));
  EXPECT_TRUE(contains(complaint({"--jobs", "many"}), "--jobs: 'many' is not a number"));
  EXPECT_TRUE(contains(complaint({"--impulses", "0:1:4"}), "0 must be above 0"));
  EXPECT_TRUE(contains(complaint({"--impulses", "4:1:2"}), "is not a range"));
  EXPECT_TRUE(contains(complaint({"--impulses", "1:0:2"}), "is not a range"));
  EXPECT_TRUE(contains(complaint({"--impulses", "1:2"}), "is not a range; use FIRST:STEP:LAST"));
  EXPECT_TRUE(contains(complaint({"--impulses", "4,two"}), "'two' is not a number"));
  EXPECT_TRUE(contains(complaint({"--impulses", "2,2"}), "2 is given twice"));
  EXPECT_TRUE(contains(complaint({"--step-times", "0.05"}), "before the push ends"));
  EXPECT_TRUE(contains(complaint({"--controllers", "mpcc"}), "did you mean 'mpc'"));
  EXPECT_TRUE(contains(complaint({"--controllers", "mpc,mpc"}), "given twice"));
  EXPECT_TRUE(contains(complaint({"--set", "push.impulse=4"}), "see --impulses"));
  EXPECT_TRUE(contains(complaint({"--set", "push.impuls=4"}), "did you mean 'push.impulse'"));
  EXPECT_TRUE(contains(complaint({"--out", "a", "--out", "b"}), "given twice"));
  EXPECT_TRUE(contains(complaint({"--quiet", "--json"}), "give one of them"));
}

TEST(MapCommandLine, StampContainsRelevantSettings) {
  const std::string plain = parse({}).settings;
  EXPECT_EQ(plain, parse({"--directions", "8", "--jobs", "1", "--all", "--impulses", "3", "--set",
                          "pictures=false"})
                       .settings);
  EXPECT_NE(plain, parse({"--set", "mpc.intervals=20"}).settings);
  EXPECT_NE(plain, parse({"--plant", "dart"}).settings);
}

// ---- cells ----

TEST(MapCells, RunMatchesTheCell) {
  const BipedSettings c = with_cell({}, {MapController::capture_point, 0.45, 270.0, 3.0});
  EXPECT_EQ(c.controller, BipedSettings::Controller::capture_point);
  EXPECT_TRUE(c.step.allowed);
  EXPECT_EQ(c.step.duration, 0.45);
  EXPECT_EQ(c.push.impulse, 3.0);
  EXPECT_EQ(c.push.direction, (Vec<double, 3>(0.0, -1.0, 0.0)));  // exactly
  EXPECT_EQ(with_cell({}, {MapController::mpc, 0.3, 90.0, 1.0}).push.direction,
            (Vec<double, 3>(0.0, 1.0, 0.0)));
  EXPECT_NEAR(with_cell({}, {MapController::mpc, 0.3, 45.0, 1.0}).push.direction[1], std::sqrt(0.5),
              1e-15);
  const BipedSettings standing = with_cell({}, {MapController::none, 0.0, 180.0, 3.0});
  EXPECT_FALSE(standing.step.allowed);
  EXPECT_EQ(standing.controller, BipedSettings::Controller::mpc);
}

TEST(MapCells, LinesReadBack) {
  MapRow row;
  row.cell = {MapController::none, 0.0, 22.5, 1.0 / 3.0};
  row.outcome = MapOutcome::not_recovered;
  row.bound = 5.3;
  row.reason = "fell, \"hard\",\nand early";
  row.icp_furthest = 0.1 + 0.2;
  row.failed_solves = 2;
  row.stepped = true;
  row.seconds = 0.25;
  const auto back_again = from_line(to_line(row));
  ASSERT_TRUE(back_again);
  EXPECT_EQ(back_again->cell, row.cell);
  EXPECT_EQ(back_again->outcome, row.outcome);
  EXPECT_EQ(back_again->reason, "fell; 'hard'; and early");
  EXPECT_EQ(back_again->icp_furthest, row.icp_furthest);
  EXPECT_TRUE(std::isnan(back_again->touchdown));
  EXPECT_EQ(back_again->failed_solves, 2);
  EXPECT_TRUE(back_again->stepped);
  EXPECT_EQ(back_again->seconds, 0.25);
  EXPECT_FALSE(from_line(to_line(row) + ","));
  EXPECT_FALSE(from_line("mpc,0.6,0"));
  EXPECT_FALSE(from_line(""));
}

// ---- the plan ----

constexpr double made_up_bound = 3.2;  // N s, plus 1 for each second of step time

MapPlan plan_of(MapGrid grid) {
  return {std::move(grid), [](const MapCell& c) { return made_up_bound + c.step_time; }};
}

MapRow row_of(const MapCell& cell, bool recovered, bool stepped = true) {
  MapRow row;
  row.cell = cell;
  row.bound = made_up_bound + cell.step_time;
  row.outcome = recovered ? MapOutcome::recovered : MapOutcome::not_recovered;
  row.stepped = stepped;
  row.seconds = 2.0;
  return row;
}

// One ray of eight impulses.
MapGrid one_ray(bool all = false) {
  return {{0.0}, {1, 2, 3, 4, 5, 6, 7, 8}, {0.6}, {MapController::mpc}, all};
}

// Runs a plan in which a cell is recovered or not, and returns the impulses that were run.
std::vector<double> impulses_run(MapPlan& plan, const std::function<bool(double)>& recovers) {
  std::vector<double> run;
  while (const auto cell = plan.next()) {
    run.push_back(cell->impulse);
    plan.finish(row_of(*cell, recovers(cell->impulse)));
  }
  return run;
}

// A planner that chooses the step times has one ray per direction.
TEST(MapCommandLine, OptimalControlHasNoStepTimes) {
  const MapRequest request = parse({"--set", "step.planner=ocp", "--set", "stance=both"});
  EXPECT_TRUE(request.grid.step_times.empty());
  EXPECT_TRUE(contains(complaint_of([] {
                         parse({"--set", "step.planner=ocp", "--step-times", "0.6"});
                       }),
                       "--step-times: step.planner=ocp chooses the times itself"));
  const MapPlan plan(request.grid, [](const MapCell&) { return made_up_bound; });
  EXPECT_EQ(plan.cells(), 16 * 16 * 3);
  MapCell cell{MapController::mpc, 0.0, 0.0, 1.0};
  EXPECT_EQ(with_cell({}, cell).step.duration, BipedSettings{}.step.duration);
  EXPECT_TRUE(with_cell({}, cell).step.allowed);
}

TEST(MapPlan, OppositeDirectionsComeFirst) {
  const std::vector<double> order = directions_far_apart(16);
  ASSERT_EQ(order.size(), 16u);
  EXPECT_EQ(std::vector<double>(order.begin(), order.begin() + 8),
            (std::vector<double>{0, 180, 90, 270, 45, 225, 135, 315}));
  for (const int n : {1, 2, 3, 5, 8, 12, 360}) {
    std::vector<double> all = directions_far_apart(n);
    std::sort(all.begin(), all.end());
    ASSERT_EQ(all.size(), static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) EXPECT_EQ(all[static_cast<std::size_t>(i)], 360.0 * i / n);
  }
}

TEST(MapPlan, NoStepRunsOnceForAllStepTimes) {
  const MapPlan plan = plan_of(
      {{0.0, 90.0}, {1.0, 2.0}, {0.3, 0.6}, {MapController::mpc, MapController::none}, false});
  EXPECT_EQ(plan.cells(), 2 * 2 * (2 + 1));
}

TEST(MapPlan, ThreeFailuresBeyondTheBoundEndARay) {
  MapPlan plan = plan_of(one_ray());
  // 2 and 3 fail below the bound of 3.8 and do not count; 4, 5 and 6 do.
  EXPECT_EQ(impulses_run(plan, [](double j) { return j < 1.5; }),
            (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_TRUE(plan.is_complete());
  const MapRow& given_up = plan.rows().at({MapController::mpc, 0.6, 0.0, 8.0});
  EXPECT_EQ(given_up.outcome, MapOutcome::not_run);
  EXPECT_EQ(given_up.bound, made_up_bound + 0.6);
  EXPECT_TRUE(contains(given_up.reason, "3 smaller pushes in a row failed"));
}

TEST(MapPlan, HandlesNonMonotoneSurvival) {
  MapPlan plan = plan_of(one_ray());
  EXPECT_EQ(impulses_run(plan, [](double j) { return j == 6.0; }).size(), 8u);
}

TEST(MapPlan, AllRunsEveryCell) {
  MapPlan plan = plan_of(one_ray(true));
  EXPECT_EQ(impulses_run(plan, [](double) { return false; }).size(), 8u);
}

TEST(MapPlan, CrashedRunGivesNoOutcome) {
  MapPlan plan = plan_of(one_ray());
  int runs = 0;
  while (const auto cell = plan.next()) {
    ++runs;
    MapRow row = row_of(*cell, false);
    if (cell->impulse == 5.0 || cell->impulse == 7.0) row.outcome = MapOutcome::failed;
    plan.finish(row);
  }
  EXPECT_EQ(runs, 8);
}

// A ray runs one cell at a time, so the number of parallel runs has no effect.
TEST(MapPlan, CellsOfOneRayRunInOrder) {
  MapGrid grid = one_ray();
  grid.directions = {0.0, 180.0};
  MapPlan plan = plan_of(grid);
  const auto first = plan.next(), second = plan.next();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->direction, 0.0);
  EXPECT_EQ(second->direction, 180.0);
  EXPECT_FALSE(plan.next());
  plan.finish(row_of(*second, true));
  const auto third = plan.next();
  ASSERT_TRUE(third);
  EXPECT_EQ(third->direction, 180.0);
  EXPECT_EQ(third->impulse, 2.0);
}

TEST(MapPlan, StepTimeIsIgnoredWithoutAStep) {
  MapPlan plan = plan_of(
      {{0.0}, {1.0, 2.0}, {0.3, 0.45, 0.6}, {MapController::mpc, MapController::none}, false});
  const auto cell = plan.next();
  const std::vector<MapRow> kept = plan.finish(row_of(*cell, true, /*stepped=*/false));
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_EQ(kept[0].known_from, "");
  for (const std::size_t i : {1u, 2u}) {
    EXPECT_EQ(kept[i].cell.controller, MapController::mpc);
    EXPECT_EQ(kept[i].cell.impulse, 1.0);
    EXPECT_EQ(kept[i].known_from, "step 0.3");
    EXPECT_EQ(kept[i].seconds, 0.0);
    EXPECT_EQ(kept[i].bound,
              made_up_bound + kept[i].cell.step_time);  // the bound of this step time
  }
  EXPECT_EQ(plan.finish(row_of(*plan.next(), true)).size(), 1u);
}

TEST(MapPlan, ResumesWhereItStopped) {
  MapPlan first = plan_of(one_ray());
  std::vector<MapRow> rows;
  for (int i = 0; i < 6; ++i)
    for (const MapRow& row : first.finish(row_of(*first.next(), false))) rows.push_back(row);
  EXPECT_TRUE(first.is_complete());

  MapPlan again = plan_of(one_ray());
  for (const MapRow& row : rows) again.restore(row);
  EXPECT_EQ(again.known(), 6);
  EXPECT_EQ(again.resume().size(), 2u);  // skipped, as before
  EXPECT_FALSE(again.next());
  EXPECT_TRUE(again.is_complete());

  MapPlan all = plan_of(one_ray(true));
  for (const MapRow& row : rows) all.restore(row);
  EXPECT_TRUE(all.resume().empty());
  EXPECT_EQ(all.next()->impulse, 7.0);

  // Failed cells run again; cells of another grid stay unchanged.
  MapPlan retry = plan_of(one_ray());
  rows[0].outcome = MapOutcome::failed;
  rows[1].cell.impulse = 2.5;
  for (const MapRow& row : rows) retry.restore(row);
  EXPECT_EQ(retry.known(), 4);
  EXPECT_EQ(retry.next()->impulse, 1.0);
}

// A recovered square of radius 4 in a bound of radius 5: 16 of 25.
TEST(MapSummary, ReportsTheFractionOfTheBound) {
  MapGrid grid = one_ray();
  grid.directions = {0.0, 90.0, 180.0, 270.0};
  grid.impulses = {4, 5};
  MapPlan plan(grid, [](const MapCell&) { return 5.0; });
  const auto finish = [&](double direction) {
    for (const double impulse : grid.impulses) {
      MapRow row = row_of({MapController::mpc, 0.6, direction, impulse}, impulse < 5.0);
      row.bound = 5.0;
      plan.restore(row);
    }
  };
  for (const double direction : {0.0, 90.0, 180.0}) finish(direction);
  EXPECT_TRUE(contains(map_summary(plan), "| all, (N s)^2 | ? |"));
  finish(270.0);
  const std::string text = map_summary(plan);
  EXPECT_TRUE(contains(text, "| 90 deg | 4 | 5.0 |"));
  EXPECT_TRUE(contains(text, "| 90 deg | 64 % |"));
  EXPECT_TRUE(contains(text, "| all, (N s)^2 | 32 of 50: 64 % |"));
  // If the largest push of the grid is recovered, the share is a lower bound.
  grid.impulses = {4};
  MapPlan small(grid, [](const MapCell&) { return 5.0; });
  for (const auto& [cell, row] : plan.rows()) small.restore(row);
  EXPECT_TRUE(contains(map_summary(small), "| 90 deg | >= 64 % |"));
  EXPECT_TRUE(contains(map_summary(small), "32 of 50: >= 64 % |"));
}

TEST(MapJson, HasTheColumnsOfTheTable) {
  MapGrid grid = one_ray();
  grid.directions = {90.0};
  grid.impulses = {4, 5};
  MapPlan plan(grid, [](const MapCell&) { return 5.0; });
  for (const double impulse : grid.impulses) {
    MapRow row = row_of({MapController::mpc, 0.6, 90.0, impulse}, impulse < 5.0);
    row.bound = 5.0;
    plan.restore(row);
  }
  const auto cells = nlohmann::ordered_json::parse(map_json(plan));
  ASSERT_EQ(cells.size(), 2U);
  EXPECT_EQ(cells[0]["controller"], "mpc");
  EXPECT_EQ(cells[0]["impulse_ns"], 4.0);
  EXPECT_EQ(cells[0]["outcome"], name_of(MapOutcome::recovered));
  EXPECT_EQ(cells[1]["outcome"], name_of(MapOutcome::not_recovered));
  EXPECT_TRUE(cells[1]["icp_settling_s"].is_null());
  std::string names;
  for (const auto& [name, value] : cells[0].items()) names += (names.empty() ? "" : ",") + name;
  EXPECT_EQ(names, map_header());
}

TEST(MapPlan, EstimatesTimeFromSimilarCells) {
  MapGrid grid = one_ray(true);
  grid.directions = {0.0, 180.0};
  MapPlan plan = plan_of(grid);
  EXPECT_FALSE(plan.seconds_left(1));
  for (int i = 0; i < 8; ++i) plan.finish(row_of(*plan.next(), true));  // 2 s each
  EXPECT_DOUBLE_EQ(*plan.seconds_left(1), 16.0);
  EXPECT_DOUBLE_EQ(*plan.seconds_left(4), 4.0);
}

// ---- the file ----

TEST(MapFile, KeepsCompleteLines) {
  const TemporaryFolder folder;
  {
    MapFile file(folder.path(), "a: 1\n");
    file.append(row_of({MapController::mpc, 0.6, 0.0, 1.0}, true));
    EXPECT_TRUE(contains(complaint_of([&] { MapFile other(folder.path(), "a: 1\n"); }),
                         "another process is writing"));
  }
  const std::string whole = file_content(folder / map_csv);
  std::ofstream(folder / map_csv, std::ios::app) << "mpc,0.6,0,2,recov";
  MapFile file(folder.path(), "a: 1\n");
  EXPECT_EQ(file.rows().size(), 1u);
  EXPECT_EQ(file_content(folder / map_csv), whole);
  file.append(row_of({MapController::mpc, 0.6, 0.0, 2.0}, false));
  EXPECT_TRUE(file_content(folder / map_csv).starts_with(whole));
}

TEST(MapFile, RejectsAnotherMap) {
  const TemporaryFolder folder;
  const std::string settings = "plant: dart\nmpc:\n  step: 0.01  # s\n  intervals: 15\n";
  { MapFile file(folder.path(), "without: cells\n"); }
  {
    MapFile file(folder.path(), settings);
    file.append(row_of({MapController::mpc, 0.6, 0.0, 1.0}, true));
  }
  const auto complaint = [&](const std::string& now) {
    return complaint_of([&] { MapFile file(folder.path(), now); });
  };
  EXPECT_EQ(complaint(settings), "no complaint");
  EXPECT_TRUE(contains(complaint("plant: dart\nmpc:\n  step: 0.01  # s\n  intervals: 20\n"),
                       "'mpc.intervals: 15' there, 'mpc.intervals: 20' now"));
  EXPECT_TRUE(contains(complaint(settings + "new: 1\n"), "'new: 1' is new"));
  EXPECT_TRUE(contains(complaint("plant: dart\n"), "is missing now"));
  std::ofstream(folder / map_csv, std::ios::app) << "mpc,no,row\n";
  EXPECT_TRUE(contains(complaint(settings), "map.csv:3 cannot be read"));
  std::ofstream(folder / map_csv) << std::string(400, 'c') << ",other,columns\n";
  EXPECT_TRUE(contains(complaint(settings), "another version"));
  std::filesystem::remove(folder / map_csv);
  EXPECT_TRUE(contains(complaint(settings), "results of another kind"));
}

// ---- complete maps, on the centroidal model ----

TEST(Map, RunsFourCellsEndToEnd) {
  const TemporaryFolder folder;
  // Forward only. Without a step, the robot recovers from 2 N s but not from 20 N s.
  const Words words{"--directions",  "1",
                    "--impulses",    "2,20",
                    "--step-times",  "0.6",
                    "--jobs",        "2",
                    "--controllers", "capture_point,none",
                    "--set",         "pictures=false",
                    "--set",         "push.start=0.1",
                    "--out",         folder.path().string()};
  ASSERT_EQ(run_map(parse(words)), ExitStatus::ok);
  const std::string csv = file_content(folder / map_csv);
  {
    const MapRequest request = parse(words);
    MapPlan plan = plan_of(request.grid);
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, map_header());
    while (std::getline(lines, line)) {
      const auto row = from_line(line);
      ASSERT_TRUE(row) << line;
      plan.restore(*row);
      EXPECT_EQ(row->failed_solves, 0) << line;
      EXPECT_EQ(row->outcome == MapOutcome::recovered, row->reason.empty()) << line;
    }
    EXPECT_TRUE(plan.is_complete()) << csv;
    const auto& rows = plan.rows();
    const MapRow& stands = rows.at({MapController::none, 0.0, 0.0, 2.0});
    EXPECT_EQ(stands.outcome, MapOutcome::recovered) << stands.reason;
    EXPECT_GT(stands.com_height_min, height_lowest);
    EXPECT_GT(stands.icp_furthest, 0.0);
    EXPECT_LT(stands.icp_furthest, 0.1065);  // the sole's edge
    const MapRow& falls = rows.at({MapController::none, 0.0, 0.0, 20.0});
    EXPECT_EQ(falls.outcome, MapOutcome::not_recovered);
    EXPECT_FALSE(falls.reason.empty());
    const MapRow& steps = rows.at({MapController::capture_point, 0.6, 0.0, 20.0});
    EXPECT_TRUE(steps.stepped);
    EXPECT_FALSE(rows.at({MapController::capture_point, 0.6, 0.0, 2.0}).stepped);
    EXPECT_TRUE(contains(map_summary(plan), "| 0 deg |"));
  }
  // A second call runs and writes nothing. Other settings are refused.
  ASSERT_EQ(run_map(parse(words)), ExitStatus::ok);
  EXPECT_EQ(file_content(folder / map_csv), csv);
  Words other = words;
  other.insert(other.end(), {"--set", "push.duration=0.2"});
  EXPECT_TRUE(contains(complaint_of([&] { run_map(parse(other)); }), "push.duration: 0.1"));
  // The cell of a missing line runs again, with the same figures except its time.
  const std::size_t last = csv.find_last_of('\n', csv.size() - 2) + 1;
  std::filesystem::resize_file(folder / map_csv, last);
  ASSERT_EQ(run_map(parse(words)), ExitStatus::ok);
  auto lost = from_line(csv.substr(last, csv.size() - last - 1));
  const std::string now = file_content(folder / map_csv);
  const auto found = from_line(now.substr(last, now.size() - last - 1));
  ASSERT_TRUE(lost && found);
  lost->seconds = found->seconds;
  EXPECT_EQ(to_line(*lost), to_line(*found));
}

// Rows are in the order in which cells end. The set of rows and their contents are the same.
TEST(Map, IsBitIdenticalForAnyNumberOfJobs) {
  std::vector<std::set<std::string>> lines;
  for (const char* jobs : {"1", "3"}) {
    const TemporaryFolder folder;
    const Words words{"--directions",  "2",
                      "--impulses",    "2,20",
                      "--step-times",  "0.6",
                      "--jobs",        jobs,
                      "--controllers", "mpc",
                      "--set",         "pictures=false",
                      "--set",         "push.start=0.1",
                      "--out",         folder.path().string()};
    ASSERT_EQ(run_map(parse(words)), ExitStatus::ok);
    lines.emplace_back();
    const MapFile file(folder.path(), file_content(folder / map_settings));
    for (MapRow row : file.rows()) {
      row.seconds = 0.0;
      lines.back().insert(to_line(row));
    }
  }
  EXPECT_EQ(lines[0].size(), 4u);
  EXPECT_EQ(lines[0], lines[1]);
}

TEST(Map, ReportsCommonErrorsBeforeWriting) {
  const char* urdf = std::getenv("SALTUS_ICUB_URDF");
  if (urdf == nullptr) GTEST_SKIP() << "SALTUS_ICUB_URDF does not name iCubGazeboV2_5's URDF";
  const TemporaryFolder folder;
  const MapRequest request =
      parse({"--plant", "dart", "--set", "push.link=chast", "--out", (folder / "map").string()});
  EXPECT_TRUE(contains(complaint_of([&] { run_map(request); }), "did you mean \"chest\"?"));
  EXPECT_FALSE(std::filesystem::exists(folder / "map"));
}

TEST(Map, DrawsAPicture) {
  if (std::system("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null") != 0)
    GTEST_SKIP() << "there is no matplotlib";
  const TemporaryFolder folder;
  const MapRequest request =
      parse({"--directions", "2", "--impulses", "2", "--step-times", "0.6", "--controllers",
             "capture_point", "--out", folder.path().string()});
  ASSERT_EQ(run_map(request), ExitStatus::ok);
  EXPECT_GT(std::filesystem::file_size(folder / "map.png"), 1000u);
}

TEST(Map, InterruptKeepsCompletedCells) {
  const TemporaryFolder folder;
  const MapRequest request =
      parse({"--impulses", "0.1:0.1:50", "--step-times", "0.6", "--controllers", "capture_point",
             "--set", "pictures=false", "--jobs", "1", "--out", folder.path().string()});
  const pid_t process = ::fork();
  if (process == 0) {
    run_map(request);
    ::_exit(0);  // would mean that it was not interrupted
  }
  const auto lines = [&] {
    const std::string csv = file_content(folder / map_csv);
    return std::count(csv.begin(), csv.end(), '\n');
  };
  while (lines() < 4) ::usleep(10'000);
  ::kill(process, SIGTERM);
  int status = 0;
  ASSERT_EQ(::waitpid(process, &status, 0), process);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
  const auto written = lines();
  EXPECT_LT(written, 16 * 500);
  const MapFile file(folder.path(), file_content(folder / map_settings));
  EXPECT_EQ(static_cast<long>(file.rows().size()), written - 1);  // no row was truncated
}

// The reason why a result may be copied from another step time.
TEST(Map, RunsWithoutAStepAreTheSame) {
  std::vector<MapRow> rows;
  for (const double step_time : {0.3, 0.6}) {
    const MapCell cell{MapController::capture_point, step_time, 0.0, 3.0};
    Config base;
    base.push.start = 0.1;
    Config config = base;
    static_cast<BipedSettings&>(config) = with_cell(base, cell);
    const RunLog log = simulate(config, icub());
    rows.push_back(map_row({}, 0.0, config.push, log, judge(config, log)));
    EXPECT_FALSE(rows.back().stepped);
  }
  EXPECT_EQ(to_line(rows[0]), to_line(rows[1]));
}

}  // namespace
}  // namespace saltus::push_recovery
