#include "saltus/robots/report/body_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "saltus/core/error.hpp"
#include "saltus/ocp/window.hpp"

namespace saltus::push_recovery {
namespace {

using Json = nlohmann::ordered_json;

void check(const RunLog& log, const FloatingRobot& robot) {
  if (log.body.size() != log.samples.size())
    throw DefinitionError(fmt::format("the log has {} samples of the body, expected {}",
                                      log.body.size(), log.samples.size()));
  for (const BodySample& b : log.body)
    if (b.state.q.size() != robot.joints() || b.torques.size() != robot.joints())
      throw DefinitionError(fmt::format("{}: a sample has {} joints and {} torques, expected {}",
                                        robot.name, b.state.q.size(), b.torques.size(),
                                        robot.joints()));
}

// Forces and torques in the axes of a sole.
Vec<double, 6> in_sole(const Eigen::Isometry3d& sole, const Vec<double, 6>& world) {
  Vec<double, 6> w;
  w << sole.linear().transpose() * world.head<3>(), sole.linear().transpose() * world.tail<3>();
  return w;
}

// Measured wrenches, left and right, in the axes of their soles.
std::vector<Vec<double, 12>> measured_wrenches(const RunLog& log) {
  std::vector<Vec<double, 12>> wrenches;
  wrenches.reserve(log.body.size());
  for (const BodySample& b : log.body) {
    Vec<double, 12> w;
    w << in_sole(b.left_sole, b.left), in_sole(b.right_sole, b.right);
    wrenches.push_back(w);
  }
  return wrenches;
}

// Mean over the samples of (t - wrench_filter, t]. Summed afresh: no error accumulates.
std::vector<Vec<double, 12>> filtered(const RunLog& log,
                                      const std::vector<Vec<double, 12>>& wrenches) {
  std::vector<Vec<double, 12>> means;
  means.reserve(wrenches.size());
  std::size_t first = 0;
  for (std::size_t i = 0; i < wrenches.size(); ++i) {
    while (log.samples[first].time <= log.samples[i].time - wrench_filter + same_instant) ++first;
    Vec<double, 12> sum = Vec<double, 12>::Zero();
    for (std::size_t k = first; k <= i; ++k) sum += wrenches[k];
    means.emplace_back(sum / static_cast<double>(i - first + 1));
  }
  return means;
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

Json boxes_json(const std::vector<UrdfBox>& boxes) {
  Json list = Json::array();
  for (const UrdfBox& box : boxes) {
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
    for (const UrdfVisual& visual : look.visuals) {
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

}  // namespace

std::vector<Vec<double, 12>> filtered_wrenches(const RunLog& log) {
  return filtered(log, measured_wrenches(log));
}

std::vector<Vec<double, 2>> sole_slip(const RunLog& log) {
  std::vector<Vec<double, 2>> slips;
  slips.reserve(log.body.size());
  const BodySample* landed = nullptr;
  for (std::size_t i = 0; i < log.body.size(); ++i) {
    const BodySample& b = log.body[i];
    if (landed == nullptr && log.samples[i].two_feet) landed = &b;
    const auto moved = [](const Eigen::Isometry3d& now, const Eigen::Isometry3d& then) {
      return (now.translation() - then.translation()).head<2>().norm();
    };
    const BodySample& first = log.body.front();
    const bool left_stands = log.final_scene.side == Side::left;
    const BodySample* left = left_stands ? &first : landed;
    const BodySample* right = left_stands ? landed : &first;
    slips.emplace_back(left == nullptr ? 0.0 : moved(b.left_sole, left->left_sole),
                       right == nullptr ? 0.0 : moved(b.right_sole, right->right_sole));
  }
  return slips;
}

CsvTable body_table(const RunLog& log, const FloatingRobot& robot) {
  check(log, robot);
  const std::vector<std::string> pose{"x", "y", "z", "qw", "qx", "qy", "qz"};
  const std::vector<std::string> wrench{"fx", "fy", "fz", "tx", "ty", "tz"};
  std::vector<std::string> columns{"t"};
  const auto add = [&columns](const std::string& prefix, const std::vector<std::string>& entries) {
    for (const std::string& entry : entries) columns.push_back(prefix + entry);
  };
  add("base_", pose);
  for (const char* quantity : {"q_", "tau_"})
    for (std::size_t i = 1; i < robot.bodies.size(); ++i)
      columns.push_back(quantity + robot.bodies[i].joint);
  for (const char* kind : {"planned", "measured", "filtered"})
    for (const char* foot : {"left", "right"}) add(fmt::format("{}_{}_", foot, kind), wrench);
  for (const char* foot : {"left", "right"}) add(fmt::format("{}_sole_", foot), pose);
  add("", {"left_slip", "right_slip"});

  CsvTable table(columns);
  const std::vector<Vec<double, 12>> measured = measured_wrenches(log);
  const std::vector<Vec<double, 12>> means = filtered(log, measured);
  const std::vector<Vec<double, 2>> slips = sole_slip(log);
  std::vector<double> row;
  for (std::size_t i = 0; i < log.body.size(); ++i) {
    const BodySample& b = log.body[i];
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
    table.add_row(row);
  }
  return table;
}

Json robot_shape(const FloatingRobot& robot, const RunLog& log) {
  Json bodies = Json::array();
  for (const FloatingRobot::Body& b : robot.bodies) {
    Json json = pose_json(b.origin);
    json["name"] = b.name;
    json["parent"] = b.parent;
    json["joint"] = b.joint;
    json["axis"] = numbers(b.axis);
    json["limits"] = {b.position.lower, b.position.upper};
    json["effort"] = b.effort;
    json["mass"] = b.mass;
    json["com"] = numbers(b.com);
    json["boxes"] = boxes_json(b.boxes);
    json["looks"] = looks_json(b.looks);
    bodies.push_back(json);
  }
  return {{"name", robot.name},
          {"mass_kg", robot.total_mass},
          {"urdf", robot.source.empty() ? "" : std::filesystem::absolute(robot.source).string()},
          {"bodies", bodies},
          {"left_sole", frame_json(robot.left_sole, log.robot.left_foot)},
          {"right_sole", frame_json(robot.right_sole, log.robot.right_foot)}};
}

Vec<double, 2> peak_forces(const RunLog& log) {
  Vec<double, 2> peak = Vec<double, 2>::Zero();
  for (const Vec<double, 12>& w : filtered_wrenches(log))
    peak = peak.cwiseMax(Vec<double, 2>(w[2], w[8]));
  return peak;
}

Json body_figures(const RunLog& log, const FloatingRobot& robot) {
  check(log, robot);
  double torque_share = 0.0;
  std::string torque_joint;
  const Vec<double, 2> peak = peak_forces(log);
  for (const BodySample& b : log.body)
    for (int i = 0; i < robot.joints(); ++i) {
      const FloatingRobot::Body& driven = robot.bodies[static_cast<std::size_t>(i) + 1];
      const double share = std::abs(b.torques[i]) / driven.effort;
      if (share <= torque_share) continue;
      torque_share = share;
      torque_joint = driven.joint;
    }
  Vec<double, 2> slip = Vec<double, 2>::Zero();
  for (const Vec<double, 2>& s : sole_slip(log)) slip = slip.cwiseMax(s);
  const double simulated = log.samples.back().time;
  const auto per_second = [simulated](double seconds) {
    return simulated > 0.0 ? seconds / simulated : 0.0;
  };
  return {{"left_force_peak_n", peak[0]},
          {"right_force_peak_n", peak[1]},
          {"left_slip_max_m", slip[0]},
          {"right_slip_max_m", slip[1]},
          {"torque_share_max", torque_share},
          {"torque_share_joint", torque_joint},
          {"planner_s_per_s", per_second(log.plan_seconds)},
          {"whole_body_control_s_per_s", per_second(log.control_seconds)},
          {"plant_s_per_s", per_second(log.plant_seconds)},
          {"control_steps", log.control_calls},
          {"control_failures", log.control_failures},
          {"control_cuts", log.control_cuts}};
}

void write_body(const OutputFolder& output, const RunLog& log, const FloatingRobot& robot) {
  output.write("body.csv", body_table(log, robot));
  output.write("robot.json", robot_shape(robot, log));
}

}  // namespace saltus::push_recovery
