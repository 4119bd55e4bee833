#include "problems/biped/report/run_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "saltus/app/version.hpp"
#include "saltus/robots/walking/hardware_limits.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/whole_body/ground.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;

// Step plans, and the processor time of their ticks.
Json step_plans(const RunLog& log) {
  LatencyHistogram all, several;
  int infeasible = 0;
  double first = infinity;
  for (const RunLog::Plan& record : log.step_plans) {
    all.add(record.seconds);
    if (record.plan.alternatives >= 3) several.add(record.seconds);
    if (!record.plan.is_feasible && infeasible++ == 0) first = record.time;
  }
  Json json = {{"ticks", log.step_plans.size()},
               {"processor_us", latency(all)},
               {"ticks_with_three_alternatives", several.count()},
               {"ticks_without_feasible_alternative", infeasible},
               {"first_without_s", first}};  // null if there is none
  if (several.count() > 0) json["processor_us_with_three"] = latency(several);
  return json;
}

Json points(const SupportPolygon& polygon) {
  Json list = Json::array();
  for (const Point2& p : polygon.vertices()) list.push_back({p[0], p[1]});
  return list;
}

Json direction(const Push& push) {
  return std::vector<double>(push.direction.begin(), push.direction.end());
}

// Poses are those of the centres; the rotation is (w, x, y, z).
Json ground_boxes_json(const Plant::Ground& ground) {
  Json list = Json::array();
  for (const GroundBox& box : ground_boxes({.ground = ground})) {
    const Vec<double, 3> at = box.pose.translation();
    const Eigen::Quaterniond q(box.pose.linear());
    list.push_back({{"position", {at[0], at[1], at[2]}},
                    {"rotation", {q.w(), q.x(), q.y(), q.z()}},
                    {"size", {box.size[0], box.size[1], box.size[2]}},
                    {"soft", box.is_soft}});
  }
  return list;
}

}  // namespace

Json latency(const LatencyHistogram& h) {
  return {{"median", 1e6 * h.median()},
          {"p99", 1e6 * h.p99()},
          {"p999", 1e6 * h.p999()},
          {"max", 1e6 * h.max()}};
}

Json summary(const BipedSettings& settings, const RunLog& log, const Verdict& verdict) {
  int failures = 0, missed = 0;
  double violation = 0.0, kkt = 0.0;
  Json provenance, latency_by_provenance;
  for (int i = 0; i < provenances; ++i) {
    const auto p = static_cast<Provenance>(i);
    provenance[describe(p)] = log.statistics.count(p);
    if (log.statistics.count(p) > 0)
      latency_by_provenance[describe(p)] = latency(log.statistics.latency[i]);
  }
  Json first_failure;
  for (const LoopLog::Tick& t : log.ticks) {
    if (t.status == SolveStatus::time_limit) {
      ++missed;
      continue;
    }
    if (is_success(t.status)) {
      violation = std::max(violation, t.violation);
      kkt = std::max(kkt, t.kkt);
      continue;
    }
    if (failures++ == 0) first_failure = {{"time_s", t.time}, {"message", t.message}};
  }
  const bool on_two_feet = log.touchdown < infinity || log.samples.back().two_feet();
  const Scene& scene = log.final_scene;
  const std::vector<Push> pushes = all_pushes(settings.push, settings.more_pushes);
  const Push& push = pushes.front();
  Json json = {
      {"recovered", verdict.recovered},
      {"reason", verdict.reason},
      {"hardware_safe", nullptr},  // null for the centroidal model
      {"hardware_reason", ""},
      {"stopped_early", log.stopped_early},
      {"fell", log.stopped_early && !log.numerical_failure && !log.interrupted},
      {"interrupted", log.interrupted},
      {"fell_before_push", verdict.fell_before_push},
      {"robot", log.robot.name},
      {"robot_source", log.robot.source},
      {"mass_kg", log.robot.mass},
      {"plant", log.plant},
      {"controller",
       settings.controller == BipedSettings::Controller::mpc ? "mpc" : "capture_point"},
      {"solver", name_of(settings.planner.solver)},
      {"solver_name", log.controller},
      {"stance", name_of(scene.side)},
      {"stepping", settings.step.allowed},
      {"push_impulse_ns", push.impulse},
      {"push_direction", direction(push)},
      {"push_start_s", push.start},
      {"push_duration_s", push.duration},
      {"push_shape", describe(push.shape)},
      {"touchdown_s", log.touchdown},  // null without a step
      {"end_s", log.samples.back().time},
      {"final_com_error_m", verdict.final_com_error},
      {"icp_settling_s", verdict.icp_settling},
      {"icp_settling_from_s", verdict.settled_from},  // also the start of force_settling
      {"com_height_min_m", verdict.com_height_min},
      {"com_height_max_m", verdict.com_height_max},
      {"angular_momentum_max", verdict.angular_momentum_max},
      {"icp_slack_max_m", violation},
      {"solves", log.ticks.size()},
      {"solve_us", latency(log.statistics.all())},
      {"solve_us_by_provenance", latency_by_provenance},
      {"deadline_misses", missed},
      {"failures", failures},
      {"first_failure", first_failure},
      {"provenance", provenance},
      {"kkt_max", kkt},
      {fmt::format("{}_sole", name_of(scene.side)),
       points(SupportPolygon::under({{scene.stance, scene.stance_foot}}))},
  };
  if (verdict.body) {
    json["hardware_safe"] = verdict.body->is_hardware_safe();
    if (!verdict.body->is_hardware_safe())
      json["hardware_reason"] = describe(verdict.body->excesses.front());
  }
  json["saltus"] = {{"version", version()}, {"commit", commit()}};
  json["seed"] = settings.plant.sensors == PlantSettings::Sensors::measured
                     ? settings.plant.sensor.seed
                     : settings.plant.noise.seed;
  if (!settings.preset.empty()) json["preset"] = settings.preset;
  if (log.statistics.check.count() > 0) json["check_us"] = latency(log.statistics.check);
  if (on_two_feet) {
    json[fmt::format("{}_sole", name_of(other(scene.side)))] =
        points(SupportPolygon::under({{scene.swing, scene.swing_foot}}));
    json["hull"] = points(scene.hull());
  }
  json["pushes"] = Json::array();  // all pushes; the keys above belong to the first
  for (const Push& each : pushes)
    json["pushes"].push_back({{"start_s", each.start},
                              {"duration_s", each.duration},
                              {"impulse_ns", each.impulse},
                              {"direction", direction(each)}});
  json["steps"] = Json::array();
  for (const RunLog::Step& step : log.steps)
    json["steps"].push_back({{"foot", name_of(step.foot)},
                             {"lift_off_s", step.lift_off},
                             {"due_s", step.due},
                             {"touchdown_s", step.touchdown},  // null if it never landed
                             {"place_m", {step.place[0], step.place[1]}},
                             {"landed_at_m", {step.landed_at[0], step.landed_at[1]}}});
  json["ground"] = Json::array();  // support over time
  for (const RunLog::Ground& record : log.ground)
    json["ground"].push_back({{"from_s", record.from},
                              {"left", record.left},
                              {"right", record.right},
                              {"corners", points(record.polygon)}});
  if (!log.plant_ground.is_level()) json["ground_boxes"] = ground_boxes_json(log.plant_ground);
  if (!log.step_plans.empty()) json["step_plans"] = step_plans(log);
  const Vec<double, 2> target = scene.target_point();
  json["target"] = {target[0], target[1]};
  return json;
}

CsvTable trajectory_table(const RunLog& log) {
  std::vector<std::string> columns{"t [s]",       "com_x [m]",   "com_y [m]",   "com_z [m]",
                                   "vel_x [m/s]", "vel_y [m/s]", "vel_z [m/s]", "h_x [Nms]",
                                   "h_y [Nms]",   "h_z [Nms]",   "icp_x [m]",   "icp_y [m]"};
  for (const char* foot : {"left", "right"})
    for (const char* entry : {"fx [N]", "fy [N]", "fz [N]", "tx [Nm]", "ty [Nm]", "tz [Nm]"})
      columns.push_back(fmt::format("{}_{}", foot, entry));
  for (const char* c : {"push_x [N]", "push_y [N]", "push_z [N]", "two_feet"})
    columns.emplace_back(c);
  CsvTable table(columns);
  std::vector<double> row;
  for (const BipedSample& s : log.samples) {
    row = {s.time};
    row.insert(row.end(), s.gamma.begin(), s.gamma.end());
    row.insert(row.end(), s.capture_point.begin(), s.capture_point.end());
    row.insert(row.end(), s.wrenches.begin(), s.wrenches.end());
    row.insert(row.end(), s.push.begin(), s.push.end());
    row.push_back(s.two_feet() ? 1.0 : 0.0);
    table.add_row(row);
  }
  return table;
}

CsvTable step_table(const RunLog& log) {
  CsvTable table({"right_foot", "lift_off [s]", "due [s]", "touchdown [s]", "place_x [m]",
                  "place_y [m]", "landed_x [m]", "landed_y [m]"});
  for (const RunLog::Step& s : log.steps)
    table.add_row(std::array<double, 8>{s.foot == Side::right ? 1.0 : 0.0, s.lift_off, s.due,
                                        s.touchdown, s.place[0], s.place[1], s.landed_at[0],
                                        s.landed_at[1]});
  return table;
}

CsvTable plan_table(const RunLog& log) {
  std::vector<std::string> columns{
      "t [s]",       "steps",       "right_foot", "lift_off [s]", "landing [s]",
      "place_x [m]", "place_y [m]", "chosen",     "feasible",     "processor time [us]"};
  for (int i = 0; i < StepPlan::most_alternatives; ++i)
    for (const char* entry :
         {"steps", "right_foot", "cost", "place_x [m]", "place_y [m]", "landing [s]"})
      columns.push_back(fmt::format("alternative_{}_{}", i + 1, entry));
  CsvTable table(columns);
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> row;
  for (const RunLog::Plan& record : log.step_plans) {
    const StepPlan& plan = record.plan;
    const StepPlan::Step& first = plan.steps[0];
    row = {record.time, static_cast<double>(plan.count)};
    if (plan.count > 0)
      row.insert(row.end(), {first.foot == Side::right ? 1.0 : 0.0, first.lift_off, first.landing,
                             first.place[0], first.place[1]});
    else
      row.insert(row.end(), 5, none);
    row.push_back(plan.chosen < 0 ? none : plan.chosen + 1.0);
    row.insert(row.end(), {plan.is_feasible ? 1.0 : 0.0, 1e6 * record.seconds});
    for (int i = 0; i < StepPlan::most_alternatives; ++i) {
      const StepPlan::Alternative& a = plan.alternative[static_cast<std::size_t>(i)];
      if (i < plan.alternatives)
        row.insert(row.end(), {static_cast<double>(a.steps), a.first == Side::right ? 1.0 : 0.0,
                               a.cost, a.place[0], a.place[1], a.landing});
      else
        row.insert(row.end(), 6, none);
    }
    table.add_row(row);
  }
  return table;
}

CsvTable tick_table(const RunLog& log) {
  CsvTable table({"t [s]", "provenance", "status", "solve time [us]", "iterations", "cost", "kkt",
                  "icp_slack [m]"});
  for (const LoopLog::Tick& t : log.ticks)
    table.add_row(std::array<double, 8>{
        t.time, static_cast<double>(*t.provenance), static_cast<double>(t.status), 1e6 * t.seconds,
        static_cast<double>(t.iterations), t.objective, t.kkt, t.violation});
  return table;
}

// Settings that differ from their defaults. Both texts list the same keys in the same order, each
// line "key: value  # unit" or, of a section, "key:"; two spaces per level.
Json changed_settings(const std::string& effective_config, const std::string& default_config) {
  std::istringstream given(effective_config), defaults(default_config);
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

}  // namespace saltus::robots::walking
