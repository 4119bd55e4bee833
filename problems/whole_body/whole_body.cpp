#include "problems/whole_body/whole_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <utility>
#include <vector>

#include "problems/biped/keys/keys.hpp"
#include "problems/biped/report/body_output.hpp"
#include "problems/whole_body/tasks.hpp"
#include "problems/whole_body/tracking.hpp"
#include "saltus/app/python_script.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/robots/simulation/simulate.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/ipopt.hpp"

namespace saltus::whole_body {
namespace {

using Json = nlohmann::ordered_json;

robots::walking::Push no_push() {
  robots::walking::Push push;
  push.impulse = 0.0;
  push.start = 0.3;
  return push;
}

struct Config {
  std::string task = "step";
  Sizes sizes;
  Options options;
  robots::walking::RobotChoice robot;
  SolverChoice solver = SolverChoice::riccati;
  int intervals = 6;         // of each phase
  double tolerance = 1e-6;   // scaled KKT error
  double time_limit = 60.0;  // s
  double replan = 0.0;       // s
  robots::walking::Push push = no_push();
  bool track = true, pictures = true;

  double period() const { return task == "recover" && replan == 0.0 ? 0.02 : replan; }  // s
};

void declare_settings(Settings& s, Config& c) {
  s.choice("task", c.task, task_names(), "what the robot does");
  s.number("step.length_m", c.sizes.length, "m", "length of a step", between(-0.2, 0.35));
  s.number("step.width_m", c.sizes.width, "m", "distance between the soles", between(0.13, 0.25));
  s.flag("step.chosen", c.sizes.chosen,
         "task step: the plan chooses the foothold near that of the settings");
  s.number("stair.height_m", c.sizes.height, "m", "height of the stair of task step_up",
           between(0.0, 0.15));
  s.number("ramp.slope_deg", c.sizes.slope, "deg", "slope of the ramp", between(-12.0, 12.0));
  s.number("turn.angle_deg", c.sizes.turn, "deg", "turn to the left", between(-60.0, 60.0));
  s.text("robot.urdf", c.robot.urdf, "URDF of the robot; empty: the official model of iCub");
  s.text("robot.file", c.robot.file,
         "names, postures and limits of another robot with 23 joints; empty: those of iCub");
  s.number("contact.friction", c.options.friction, "", "friction coefficient in the plan",
           between(0.05, 1.0));
  s.number("limits.speed", c.options.speed, "", "usable fraction of the speeds of the joints",
           between(0.05, 1.0));
  s.number("limits.torque", c.options.torque, "",
           "usable fraction of the torques of the joints, for weight and contact forces alone",
           between(0.05, 1.0));
  s.choice("solver", c.solver, solver_choices(), "solver of the plan");
  s.integer("intervals", c.intervals, "", "intervals of each phase", between(2, 60));
  s.number("tolerance", c.tolerance, "", "scaled KKT error", between(1e-10, 1e-2));
  s.number("time_limit_s", c.time_limit, "s", "time limit of the solver", between(0.1, 3600.0));
  s.number("replan.period_s", c.replan, "s",
           "period of replanning from the measured state; 0: never, but 0.02 s in task recover",
           between(0.0, 0.2));
  robots::walking::declare_settings(s, c.push);
  robots::walking::declare_point_of_push(s, c.push);
  s.flag("track", c.track, "simulate the whole body in DART as it follows the plan");
  s.flag("pictures", c.pictures, "draw the picture at the end (needs python3 with matplotlib)");
  s.rule({"task", "replan.period_s"}, [&c] {
    return c.task == "walk" && c.replan > 0.0
               ? "task walk repeats itself and cannot be planned again: leave out replan.period_s"
               : "";
  });
}

// The ground of the task: level until the edge in front of the toes.
robots::Plant::Ground ground_of(const Config& config, const Body& body) {
  robots::Plant::Ground ground;
  ground.edge = edge_ahead(body);
  if (config.task == "step_up") {
    ground.ahead = true;
    ground.height = config.sizes.height;
  }
  if (config.task == "ramp") {
    ground.ahead = true;
    ground.slope_forward = std::tan(config.sizes.slope * std::numbers::pi / 180.0);
  }
  return ground;
}

Json tracking_json(const Tracking& t) {
  return {{"fell", t.fell},
          {"modes_begin_s", t.begins},
          {"largest_distance_of_com_m", t.com},
          {"distance_of_com_at_end_m", t.com_at_end},
          {"largest_distance_of_soles_m", t.feet},
          {"largest_slip_m", t.slip},
          {"largest_torque_over_limit", {{"value", t.torque}, {"joint", t.torque_of}}},
          {"largest_speed_over_limit", {{"value", t.speed}, {"joint", t.speed_of}}},
          {"largest_force_weights", t.force}};
}

Json replanning_json(const Replanner::Statistics& s) {
  Json json{{"solves", s.processor.count()}};
  for (int i = 0; i < provenances; ++i)
    json[describe(static_cast<Provenance>(i))] = s.counts[static_cast<std::size_t>(i)];
  json["processor_ms"] = {{"median", 1e3 * s.processor.median()},
                          {"p99", 1e3 * s.processor.p99()},
                          {"max", 1e3 * s.processor.max()}};
  return json;
}

ShootingOptions grid_of(const Config& config) {
  return {.intervals_per_phase = config.intervals, .integrator = runge_kutta4()};
}

// A task with its problem and plan.
struct Planned {
  Task task;
  OptimalControlProblem problem;
  Solution plan;
  int variables, rows;
  double set_up;  // s
};

Planned plan_task(const Config& config, const Body& body, const Sizes& sizes) {
  const auto start = WallClock::now();
  Task task = whole_body::task(config.task, body, sizes);
  OptimalControlProblem problem = whole_body::problem(body, task, config.options);
  MultipleShooting shooting(problem, grid_of(config));
  const double set_up = seconds_since(start);
  const std::unique_ptr<Solver> solver =
      make_solver(config.solver, {.tolerance = config.tolerance, .time_limit = config.time_limit});
  Solution plan = solve(shooting, *solver);
  return {std::move(task),       std::move(problem),
          std::move(plan),       shooting.nlp().variables(),
          shooting.nlp().rows(), set_up};
}

ExitStatus run_whole_body(const Config& config, const RunContext& context) {
  const auto urdf_file = robots::walking::urdf_of_body(config.robot);
  const robots::UrdfModel urdf = robots::UrdfModel::read(urdf_file);
  robots::walking::RobotChoice choice = config.robot;
  choice.urdf = urdf_file.string();
  const robots::RobotDescription description = robots::walking::robot_of(choice, true);
  robots::FloatingRobot robot =
      robots::with_drives_scaled(robots::floating_robot(urdf, description), {});
  if (robot.joints() != joints)
    throw InputError(
        fmt::format("whole_body plans for robots with {} joints, but {} has {}: list "
                    "{} joints in {}",
                    joints, robot.name, robot.joints(), joints, description.file));
  robots::add_capsules(robot, urdf, description);
  const Body body(robot, description);

  // The summary describes the first plan. Task recover has one plan for each foot.
  std::vector<Planned> planned;
  planned.push_back(plan_task(config, body, config.sizes));
  if (config.task == "recover") {
    Sizes other = config.sizes;
    other.foot = 1 - other.foot;
    planned.push_back(plan_task(config, body, other));
  }
  const Solution& plan = planned.front().plan;

  const OutputFolder& output = context.output;
  output.write("config.yaml", std::string_view(context.effective_config));
  Json summary{{"name", "whole_body"},
               {"kind", "plan"},
               {"task", config.task},
               {"ok", plan.ok()},
               {"message", plan.message},
               {"solver", name_of(config.solver)},
               {"variables", planned.front().variables},
               {"rows", planned.front().rows},
               {"iterations", plan.iterations},
               {"set_up_s", planned.front().set_up},
               {"solve_s", plan.seconds},
               {"cost", plan.cost},
               {"durations_s", plan.durations}};
  fmt::print("{}: {}\n{} variables, {} rows; {} iterations of {}, {:.2f} s; cost {:.4f}\n",
             config.task, plan.message, planned.front().variables, planned.front().rows,
             plan.iterations, name_of(config.solver), plan.seconds, plan.cost);
  if (!plan.trajectory.empty()) {
    std::ostringstream text;
    plan.trajectory.write_csv(text, 4);
    output.write("plan.csv", std::string_view(text.view()));
  }
  const bool all_ok = std::ranges::all_of(planned, [](const Planned& p) { return p.plan.ok(); });
  if (all_ok && config.track) {
    std::deque<Replanner> replanners;
    std::vector<PlannedTask> motions;
    for (const Planned& p : planned) {
      if (config.period() > 0.0)
        replanners.emplace_back(p.problem, grid_of(config), config.period(), p.plan.trajectory);
      motions.push_back(
          {&p.task, &p.plan.trajectory, replanners.empty() ? nullptr : &replanners.back()});
    }
    TrackingOptions options;
    options.waits = config.task == "recover";
    options.ground = ground_of(config, body);
    options.push = config.push;
    options.push.direction.normalize();
    options.pushed = robots::walking::pushed_frame(robot, urdf, config.push.link);
    options.pushed.pose.translate(config.push.point);
    const Tracking tracked = track(body, robot, motions, options);
    const Replanner* replanner = motions[static_cast<std::size_t>(tracked.motion)].replanner;
    output.write("tracking.csv", tracked.table);
    output.write("robot.json", robots::walking::robot_shape(robot, body.feet[0], body.feet[1]));
    summary["tracking"] = tracking_json(tracked);
    if (replanner != nullptr) summary["replanning"] = replanning_json(replanner->statistics());
    fmt::print(
        "in DART: {}; CoM within {:.1f} mm of the plan, soles within {:.1f} mm, slip {:.1f} mm\n"
        "largest torque {:.0f} % of its limit ({}), largest speed {:.0f} % ({}), largest force "
        "{:.2f} weights\n",
        tracked.fell ? fmt::format("fell at {:.2f} s", tracked.fell_at) : "tracked",
        1e3 * tracked.com, 1e3 * tracked.feet, 1e3 * tracked.slip, 100.0 * tracked.torque,
        tracked.torque_of, 100.0 * tracked.speed, tracked.speed_of, tracked.force);
    if (replanner != nullptr && replanner->statistics().processor.count() == 0) {
      fmt::print("no step: nothing moved the capture point by 3 cm\n");
    } else if (replanner != nullptr) {
      const Replanner::Statistics& s = replanner->statistics();
      fmt::print(
          "replanned {} times in {:.2f} s; processor time per solve: median {:.1f} ms, 99 % "
          "{:.1f} ms, largest {:.1f} ms\n",
          s.processor.count(), tracked.duration, 1e3 * s.processor.median(),
          1e3 * s.processor.p99(), 1e3 * s.processor.max());
    }
  }
  output.write("summary.json", summary);
  if (all_ok && config.track && config.pictures)
    run_python_module("saltus.plot_whole_body", output.path(), "picture");
  fmt::print("results in {}\n", output.path().string());
  return all_ok ? ExitStatus::ok : ExitStatus::solver_failed;
}

}  // namespace

ProblemEntry entry() {
  return problem_entry<Config>("whole_body",
                               "plans of iCub's whole body: step, walk, stair, ramp, turn and hop",
                               declare_settings, run_whole_body);
}

}  // namespace saltus::whole_body
