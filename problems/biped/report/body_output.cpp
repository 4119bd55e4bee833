#include "problems/biped/report/body_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "problems/biped/report/run_summary.hpp"
#include "saltus/core/error.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;

void check(const RunLog& log, const FloatingRobot& robot) {
  if (log.body.size() != log.samples.size())
    throw DefinitionError(fmt::format("the log has {} samples of the body, expected {}",
                                      log.body.size(), log.samples.size()));
  for (const RunLog::BodySample& b : log.body)
    if (b.state.q.size() != robot.joints() || b.torques.size() != robot.joints())
      throw DefinitionError(fmt::format("{}: a sample has {} joints and {} torques, expected {}",
                                        robot.name, b.state.q.size(), b.torques.size(),
                                        robot.joints()));
}

Eigen::Quaterniond rotation_of(const Eigen::Isometry3d& pose) {
  Eigen::Quaterniond q(pose.linear());
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return q.normalized();
}

void append_pose(std::vector<double>& row, const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q = rotation_of(pose);
  const Vec<double, 3> p = pose.translation();
  row.insert(row.end(), {p[0], p[1], p[2], q.w(), q.x(), q.y(), q.z()});
}

Json numbers(const Vec<double, 3>& v) { return {v[0], v[1], v[2]}; }

Json pose_json(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q = rotation_of(pose);
  return {{"position", numbers(pose.translation())}, {"rotation", {q.w(), q.x(), q.y(), q.z()}}};
}

Json frame_json(const FloatingRobot::Frame& frame, const FootRectangle& foot) {
  Json json = pose_json(frame.pose);
  json["body"] = frame.body;
  json["foot_x"] = {foot.x.lower, foot.x.upper};
  json["foot_y"] = {foot.y.lower, foot.y.upper};
  return json;
}

Json boxes_json(const std::vector<UrdfModel::Box>& boxes) {
  Json list = Json::array();
  for (const UrdfModel::Box& box : boxes) {
    Json entry = pose_json(box.pose);
    entry["size"] = numbers(box.size);
    list.push_back(entry);
  }
  return list;
}

Json looks_json(const std::vector<FloatingRobot::Look>& looks) {
  constexpr const char* shapes[] = {"mesh", "box", "cylinder", "sphere"};
  Json list = Json::array();
  for (const FloatingRobot::Look& look : looks) {
    Json visuals = Json::array();
    for (const UrdfModel::LinkShape& visual : look.visuals) {
      Json entry = pose_json(visual.pose);
      entry["shape"] = shapes[static_cast<int>(visual.shape)];
      if (!visual.mesh.empty()) entry["mesh"] = visual.mesh;
      entry["size"] = numbers(visual.size);
      entry["colour"] = numbers(visual.colour);
      visuals.push_back(entry);
    }
    list.push_back({{"link", look.link}, {"visuals", visuals}, {"boxes", boxes_json(look.boxes)}});
  }
  return list;
}

Json capsules_json(const std::vector<RobotDescription::LinkCapsule>& capsules) {
  Json list = Json::array();
  for (const RobotDescription::LinkCapsule& c : capsules)
    list.push_back({{"link", c.link},
                    {"from", numbers(c.capsule.from)},
                    {"to", numbers(c.capsule.to)},
                    {"radius", c.capsule.radius}});
  return list;
}

// Time after which the estimate has converged to the initial tilt of the base, s.
constexpr double estimate_settled = 0.25;

// Errors of the estimate after that time: largest error of the CoM relative to the stance sole, and
// root mean square error of its velocity. Null if the run ends earlier.
Json estimate_figures(const RunLog& log) {
  long count = 0;
  double largest = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < log.body.size(); ++i) {
    if (log.samples[i].time < estimate_settled) continue;
    ++count;
    const RunLog::BodySample& b = log.body[i];
    const Vec<double, 3> sole =
        (b.estimate->stance == Side::left ? b.left_sole : b.right_sole).translation();
    const Vec<double, 9>& truth = log.samples[i].gamma;
    const Vec<double, 9>& gamma = b.estimate->gamma;
    largest = std::max(
        largest, ((gamma.head<3>() - b.estimate->stance_sole) - (truth.head<3>() - sole)).norm());
    squares += (gamma.segment<3>(3) - truth.segment<3>(3)).squaredNorm();
  }
  if (count == 0)
    return {{"estimate_com_error_m", nullptr}, {"estimate_velocity_error_m_s", nullptr}};
  return {{"estimate_com_error_m", largest},
          {"estimate_velocity_error_m_s", std::sqrt(squares / static_cast<double>(count))}};
}

}  // namespace

CsvTable body_table(const RunLog& log, const FloatingRobot& robot) {
  check(log, robot);
  const std::vector<std::string> pose{"x [m]", "y [m]", "z [m]", "qw", "qx", "qy", "qz"};
  const std::vector<std::string> wrench{"fx [N]",  "fy [N]",  "fz [N]",
                                        "tx [Nm]", "ty [Nm]", "tz [Nm]"};
  std::vector<std::string> columns{"t [s]"};
  const auto add = [&columns](const std::string& prefix, const std::vector<std::string>& entries) {
    for (const std::string& entry : entries) columns.push_back(prefix + entry);
  };
  add("base_", pose);
  const auto add_joints = [&](const char* quantity, const char* unit) {
    for (std::size_t i = 1; i < robot.bodies.size(); ++i)
      columns.push_back(fmt::format("{}{} [{}]", quantity, robot.bodies[i].joint, unit));
  };
  add_joints("q_", "rad");
  add_joints("tau_", "Nm");
  for (const char* kind : {"planned", "measured", "filtered"})
    for (const char* foot : {"left", "right"}) add(fmt::format("{}_{}_", foot, kind), wrench);
  for (const char* foot : {"left", "right"}) add(fmt::format("{}_sole_", foot), pose);
  add("", {"left_slip [m]", "right_slip [m]", "left_friction", "right_friction"});
  add_joints("dq_", "rad/s");
  const bool has_estimate = !log.body.empty() && log.body.front().estimate;
  if (has_estimate) {
    add("estimate_base_", pose);
    add_joints("estimate_q_", "rad");
    add_joints("estimate_dq_", "rad/s");
    add("estimate_", {"com_x [m]", "com_y [m]", "com_z [m]", "vel_x [m/s]", "vel_y [m/s]",
                      "vel_z [m/s]", "h_x [Nms]", "h_y [Nms]", "h_z [Nms]"});
    add("estimate_stance_", {"x [m]", "y [m]", "z [m]", "is_left"});
  }

  CsvTable table(columns);
  const std::vector<Vec<double, 12>> measured = measured_wrenches(log);
  const std::vector<Vec<double, 12>> means = filtered_wrenches(log);
  const std::vector<Vec<double, 2>> slips = sole_slip(log), friction = friction_used(log);
  std::vector<double> row;
  for (std::size_t i = 0; i < log.body.size(); ++i) {
    const RunLog::BodySample& b = log.body[i];
    row = {log.samples[i].time};
    append_pose(row, b.state.base);
    row.insert(row.end(), b.state.q.begin(), b.state.q.end());
    row.insert(row.end(), b.torques.begin(), b.torques.end());
    row.insert(row.end(), b.planned.begin(), b.planned.end());
    row.insert(row.end(), measured[i].begin(), measured[i].end());
    row.insert(row.end(), means[i].begin(), means[i].end());
    append_pose(row, b.left_sole);
    append_pose(row, b.right_sole);
    row.insert(row.end(), slips[i].begin(), slips[i].end());
    row.insert(row.end(), friction[i].begin(), friction[i].end());
    row.insert(row.end(), b.state.dq.begin(), b.state.dq.end());
    if (has_estimate) {
      append_pose(row, b.estimate->state.base);
      row.insert(row.end(), b.estimate->state.q.begin(), b.estimate->state.q.end());
      row.insert(row.end(), b.estimate->state.dq.begin(), b.estimate->state.dq.end());
      row.insert(row.end(), b.estimate->gamma.begin(), b.estimate->gamma.end());
      row.insert(row.end(), b.estimate->stance_sole.begin(), b.estimate->stance_sole.end());
      row.push_back(b.estimate->stance == Side::left ? 1.0 : 0.0);
    }
    table.add_row(row);
  }
  return table;
}

Json robot_shape(const FloatingRobot& robot, const FootRectangle& left,
                 const FootRectangle& right) {
  Json bodies = Json::array();
  for (const FloatingRobot::Body& b : robot.bodies) {
    Json json = pose_json(b.origin);
    json["name"] = b.name;
    json["parent"] = b.parent;
    json["joint"] = b.joint;
    json["axis"] = numbers(b.axis);
    json["limits"] = {b.position.lower, b.position.upper};
    json["effort"] = b.effort;
    json["velocity"] = b.velocity;  // null without a limit
    json["mass"] = b.mass;
    json["com"] = numbers(b.com);
    json["boxes"] = boxes_json(b.boxes);
    json["looks"] = looks_json(b.looks);
    json["capsules"] = capsules_json(b.capsules);
    bodies.push_back(json);
  }
  return {{"name", robot.name},
          {"mass_kg", robot.total_mass},
          {"urdf", robot.source.empty() ? "" : std::filesystem::absolute(robot.source).string()},
          {"bodies", bodies},
          {"left_sole", frame_json(robot.left_sole, left)},
          {"right_sole", frame_json(robot.right_sole, right)}};
}

Json body_figures(const RunLog& log, const FloatingRobot& robot) {
  check(log, robot);
  double torque_fraction = 0.0;
  std::string torque_joint;
  const Vec<double, 2> peak = peak_forces(log);
  for (const RunLog::BodySample& b : log.body)
    for (int i = 0; i < robot.joints(); ++i) {
      const FloatingRobot::Body& driven = robot.bodies[static_cast<std::size_t>(i) + 1];
      const double fraction = std::abs(b.torques[i]) / driven.effort;
      if (fraction <= torque_fraction) continue;
      torque_fraction = fraction;
      torque_joint = driven.joint;
    }
  Vec<double, 2> slip = Vec<double, 2>::Zero();
  for (const Vec<double, 2>& s : sole_slip(log)) slip = slip.cwiseMax(s);
  const double simulated = log.samples.back().time;
  const auto per_second = [simulated](double seconds) {
    return simulated > 0.0 ? seconds / simulated : 0.0;
  };
  Json figures = {{"left_force_peak_n", peak[0]},
                  {"right_force_peak_n", peak[1]},
                  {"left_slip_max_m", slip[0]},
                  {"right_slip_max_m", slip[1]},
                  {"torque_share_max", torque_fraction},
                  {"torque_share_joint", torque_joint},
                  {"planner_s_per_s", per_second(log.plan_seconds)},
                  {"whole_body_control_s_per_s", per_second(log.control_seconds)},
                  {"whole_body_solve_us", latency(log.control_solves)},
                  {"plant_s_per_s", per_second(log.plant_seconds)},
                  {"control_steps", log.control_calls},
                  {"control_failures", log.control_failures},
                  {"control_cuts", log.control_cuts}};
  if (!log.body.empty() && log.body.front().estimate) figures.update(estimate_figures(log));
  if (log.mass_estimate) {
    figures["estimated_mass_kg"] = log.mass_estimate->mass;
    figures["estimated_com_shift_m"] = numbers(log.mass_estimate->com_shift);
  }
  return figures;
}

void write_body(const OutputFolder& output, const RunLog& log, const FloatingRobot& robot) {
  output.write("body.csv", body_table(log, robot));
  output.write("robot.json", robot_shape(robot, log.robot.left_foot, log.robot.right_foot));
}

}  // namespace saltus::robots::walking
