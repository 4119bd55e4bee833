#include "problems/push_recovery/run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "saltus/robots/report/body_output.hpp"
#include "saltus/robots/report/run_support.hpp"
#include "saltus/robots/walking/full_body.hpp"
#include "saltus/robots/walking/settling.hpp"
#include "saltus/robots/walking/simulation.hpp"

namespace saltus::push_recovery {
namespace {

using Json = nlohmann::ordered_json;

// Quantiles in us.
Json latency(const LatencyHistogram& h) {
  return {{"median", 1e6 * h.median()},
          {"p99", 1e6 * h.p99()},
          {"p999", 1e6 * h.p999()},
          {"max", 1e6 * h.max()}};
}

Json points(const SupportPolygon& polygon) {
  Json list = Json::array();
  for (const Point2& p : polygon.vertices()) list.push_back({p[0], p[1]});
  return list;
}

Json summary(const Config& config, const RunLog& log, const Verdict& verdict) {
  int failures = 0, missed = 0;
  double softness = 0.0, kkt = 0.0;
  Json provenance, latency_by_provenance;
  for (int i = 0; i < provenances; ++i) {
    const auto p = static_cast<Provenance>(i);
    provenance[describe(p)] = log.loop.count(p);
    if (log.loop.count(p) > 0) latency_by_provenance[describe(p)] = latency(log.loop.latency[i]);
  }
  Json first_failure;
  for (const TickRecord& t : log.ticks) {
    if (t.status == SolveStatus::time_limit) {
      ++missed;
      continue;
    }
    if (is_success(t.status)) {
      softness = std::max(softness, t.softness);
      kkt = std::max(kkt, t.kkt);
      continue;
    }
    if (failures++ == 0) first_failure = {{"time_s", t.time}, {"message", t.message}};
  }
  const bool stepped = log.touchdown < infinity;
  const Scene& scene = log.final_scene;
  Json json = {
      {"recovered", verdict.recovered},
      {"reason", verdict.reason},
      {"stopped_early", log.stopped_early},
      {"fell_before_push", verdict.fell_before_push},
      {"robot", log.robot.name},
      {"robot_source", log.robot.source},
      {"mass_kg", log.robot.mass},
      {"plant", log.plant},
      {"controller", config.controller == ControllerChoice::mpc ? "mpc" : "capture_point"},
      {"solver", name_of(config.solver)},
      {"solver_name", log.solver},
      {"stance", name_of(scene.side)},
      {"stepping", config.stepping},
      {"push_impulse_ns", config.push.impulse},
      {"push_start_s", config.push.start},
      {"push_duration_s", config.push.duration},
      {"push_shape", describe(config.push.shape)},
      {"touchdown_s", log.touchdown},  // null without a step
      {"end_s", log.samples.back().time},
      {"final_com_error_m", verdict.final_com_error},
      {"icp_settling_s", verdict.icp_settling},
      {"com_height_min_m", verdict.com_height_min},
      {"com_height_max_m", verdict.com_height_max},
      {"angular_momentum_max", verdict.angular_momentum_max},
      {"icp_slack_max_m", softness},
      {"solves", log.ticks.size()},
      {"solve_us", latency(log.loop.all())},
      {"solve_us_by_provenance", latency_by_provenance},
      {"deadline_misses", missed},
      {"failures", failures},
      {"first_failure", first_failure},
      {"provenance", provenance},
      {"kkt_max", kkt},
      {fmt::format("{}_sole", name_of(scene.side)),
       points(SupportPolygon::under({{scene.stance, scene.stance_foot}}))},
  };
  if (stepped) {
    json[fmt::format("{}_sole", name_of(other(scene.side)))] =
        points(SupportPolygon::under({{scene.swing, scene.swing_foot}}));
    json["hull"] = points(scene.hull());
  }
  const Vec<double, 2> target = scene.target_point();
  json["target"] = {target[0], target[1]};
  return json;
}

CsvTable trajectory_table(const RunLog& log) {
  std::vector<std::string> columns{"t",     "com_x", "com_y", "com_z", "vel_x", "vel_y",
                                   "vel_z", "h_x",   "h_y",   "h_z",   "icp_x", "icp_y"};
  for (const char* foot : {"left", "right"})
    for (const char* entry : {"fx", "fy", "fz", "tx", "ty", "tz"})
      columns.push_back(fmt::format("{}_{}", foot, entry));
  for (const char* c : {"push_x", "push_y", "push_z", "two_feet"}) columns.emplace_back(c);
  CsvTable table(columns);
  std::vector<double> row;
  for (const Sample& s : log.samples) {
    row = {s.time};
    row.insert(row.end(), s.gamma.begin(), s.gamma.end());
    row.insert(row.end(), s.capture_point.begin(), s.capture_point.end());
    row.insert(row.end(), s.wrenches.begin(), s.wrenches.end());
    row.insert(row.end(), s.push.begin(), s.push.end());
    row.push_back(s.two_feet ? 1.0 : 0.0);
    table.add_row(row);
  }
  return table;
}

CsvTable tick_table(const RunLog& log) {
  CsvTable table(
      {"t", "provenance", "status", "solve_us", "iterations", "cost", "kkt", "icp_slack_m"});
  for (const TickRecord& t : log.ticks)
    table.add_row(std::array<double, 8>{
        t.time, static_cast<double>(t.provenance), static_cast<double>(t.status), 1e6 * t.seconds,
        static_cast<double>(t.iterations), t.cost, t.kkt, t.softness});
  return table;
}

// Settings that differ from their defaults. Both texts list the same keys in the same order, each
// line "key: value  # unit" or, of a section, "key:"; two spaces per level.
Json changed_settings(const std::string& effective_config) {
  Config config;
  Settings settings;
  declare_settings(settings, config);
  std::istringstream given(effective_config), defaults(settings.to_yaml());
  Json changed = Json::array();
  std::vector<std::string> sections;
  for (std::string line, standard; std::getline(given, line) && std::getline(defaults, standard);) {
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    const std::size_t colon = line.find(':', indent);
    if (colon == std::string::npos) continue;
    sections.resize(indent / 2);
    sections.push_back(line.substr(indent, colon - indent));
    if (line == standard || colon + 2 > line.size()) continue;
    const std::string unit_mark = "  # ";
    const std::size_t unit = line.rfind(unit_mark);
    const auto value = [&](const std::string& text) {
      const std::size_t end = unit == std::string::npos ? text.size() : text.rfind(unit_mark);
      return text.substr(colon + 2, end - colon - 2);
    };
    changed.push_back(
        {{"key", fmt::format("{}", fmt::join(sections, "."))},
         {"value", value(line)},
         {"default", value(standard)},
         {"unit", unit == std::string::npos ? "" : line.substr(unit + unit_mark.size())}});
  }
  return changed;
}

// Nothing without a landing.
std::string settling_text(const RunLog& log, const Verdict& verdict, const ForceSettling& forces) {
  if (log.touchdown == infinity) return {};
  const auto seconds = [](double t) {
    return t < infinity ? fmt::format("{:.2f} s", t) : std::string("never");
  };
  std::string text =
      fmt::format("touch-down at {:.3f} s; after it settle: capture point {}, planned forces {}",
                  log.touchdown, seconds(verdict.icp_settling), seconds(forces.planned.maxCoeff()));
  if (!log.body.empty()) text += fmt::format(", measured {}", seconds(forces.measured.maxCoeff()));
  return text + "\n";
}

std::optional<FloatingRobot> body_of(const Config& config, const RobotDescription& robot) {
  if (config.plant == PlantChoice::centroidal) return std::nullopt;
  return floating_robot(UrdfModel::read(urdf_of_body(config)), robot);
}

bool disturbs_the_body(const Config& config) {
  return !config.noise.is_zero() || config.delay_ticks > 0 || config.ground_step != 0.0;
}

ExitStatus run(const Config& config, const RunContext& context) {
  const RobotDescription robot = robot_of(config);
  const std::optional<FloatingRobot> body = body_of(config, robot);
  for (const std::string& warning : robot.warnings) fmt::print(stderr, "warning: {}\n", warning);
  fmt::print("robot: {}, {:.2f} kg ({})\n", robot.name, robot.mass, robot.source);
  fmt::print("push: {} N s in {} s at {} s\n", config.push.impulse, config.push.duration,
             config.push.start);

  if (config.plant == PlantChoice::centroidal && disturbs_the_body(config))
    fmt::print(
        stderr,
        "noise, delay and a step in the ground are of the whole body; on the centroidal model "
        "they do nothing (use --plant dart)\n");

  const auto begin = std::filesystem::file_time_type::clock::now();
  Progress progress(stdout, isatty(fileno(stdout)) != 0);
  const auto show = [&progress](const LoopState& state) { progress.show(state); };
  const RunLog log = config.plant == PlantChoice::centroidal
                         ? simulate(config, robot, show)
                         : simulate_full_body(config, robot, urdf_of_body(config), show);
  progress.finish();
  const Verdict verdict = judge(config, log);
  const ForceSettling settling = force_settling(log);
  Json json = summary(config, log, verdict);
  json["force_settling"] = to_json(settling);
  json["changed_settings"] = changed_settings(context.effective_config);
  if (body) {
    json["push_link"] = config.push.link;
    json["push_body"] = log.floating.bodies[log.pushed.body].name;
    const Vec<double, 3> point = log.pushed.pose.translation();  // in the frame of that body
    json["push_point"] = {point[0], point[1], point[2]};
    json["body"] = body_figures(log, *body);
    json["body"].update(to_json(*verdict.body));
  }

  context.output.write("config.yaml", std::string_view(context.effective_config));
  context.output.write("trajectory.csv", trajectory_table(log));
  context.output.write("ticks.csv", tick_table(log));
  if (body) write_body(context.output, log, *body);
  context.output.write("summary.json", json);
  if (config.pictures) {
    draw(context.output.path(), "pictures (they need matplotlib)", "plot_run.py");
    draw(context.output.path(), "report", "report.py");
  }

  fmt::print("{}\n", verdict.recovered ? "recovered" : "not recovered: " + verdict.reason);
  fmt::print("CoM height {:.3f} to {:.3f} m, |H| up to {:.2f} Nms, final CoM error {:.1f} mm\n",
             verdict.com_height_min, verdict.com_height_max, verdict.angular_momentum_max,
             1e3 * verdict.final_com_error);
  fmt::print("{}", settling_text(log, verdict, settling));
  fmt::print("{} solves by {}, median {:.3f} ms, {} failed, {} cut off\n", log.ticks.size(),
             log.solver, 1e3 * log.loop.all().median(), json["failures"].get<int>(),
             json["deadline_misses"].get<int>());
  if (config.plant != PlantChoice::centroidal) {
    const double simulated = log.samples.back().time;
    fmt::print(
        "{}: per simulated second {:.3f} s planner, {:.3f} s whole-body control, {:.3f} s plant; "
        "{} "
        "of {} control steps not solved\n",
        log.plant, log.plan_seconds / simulated, log.control_seconds / simulated,
        log.plant_seconds / simulated, log.control_failures, log.control_calls);
  }
  fmt::print("{}", results_text(context.output.path(), begin));
  const bool failed =
      json["failures"].get<int>() > 0 || log.control_failed() || log.numerical_failure;
  return failed ? ExitStatus::solver_failed : ExitStatus::ok;
}

}  // namespace

ProblemEntry entry() {
  return problem_entry<Config>("push_recovery", "iCub is pushed and caught by a step",
                               declare_settings, run);
}

}  // namespace saltus::push_recovery
