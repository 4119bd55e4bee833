#include "saltus/robots/walking/body_verdict.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "saltus/robots/walking/body_forces.hpp"
#include "saltus/robots/walking/hardware_limits.hpp"
#include "saltus/robots/whole_body/clearance.hpp"

namespace saltus::robots::walking {
namespace {

// The controller meets its limits to a relative 1e-6. Values above this ratio count as at the
// limit.
constexpr double at_limit = 0.999;

double angle_between(const Vec<double, 3>& a, const Vec<double, 3>& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The vertical in the axes of the base.
Vec<double, 3> vertical(const RunLog::BodySample& b) {
  return b.state.base.linear().row(2).transpose();
}

void judge_limits(const RunLog& log, Verdict::Body& v) {
  const int joints = log.floating.joints();
  long at_their_limit = 0;
  for (std::size_t k = 0; k < log.body.size(); ++k) {
    const RunLog::BodySample& b = log.body[k];
    bool torque_at_limit = false;
    for (int i = 0; i < joints; ++i) {
      const FloatingRobot::Body& driven = log.floating.bodies[static_cast<std::size_t>(i) + 1];
      const double largest = driven.drive.torque_range(driven.effort, 0.0).upper;
      torque_at_limit |= std::abs(b.torques[i]) >= at_limit * largest;
      const double margin =
          std::min(b.state.q[i] - driven.position.lower, driven.position.upper - b.state.q[i]);
      if (margin >= v.limit_margin) continue;
      v.limit_margin = margin;
      v.limit_joint = driven.joint;
      v.limit_time = log.samples[k].time;
    }
    if (torque_at_limit) ++at_their_limit;
  }
  v.torque_limit_fraction =
      static_cast<double>(at_their_limit) / static_cast<double>(log.body.size());
}

void judge_speeds(const RunLog& log, Verdict::Body& v) {
  for (int i = 0; i < log.floating.joints(); ++i) {
    const FloatingRobot::Body& driven = log.floating.bodies[static_cast<std::size_t>(i) + 1];
    double since = infinity;  // start of the current excess
    for (std::size_t k = 0; k < log.body.size(); ++k) {
      const double t = log.samples[k].time;
      const double ratio = std::abs(log.body[k].state.dq[i]) / driven.velocity;
      if (ratio > v.speed_ratio) {
        v.speed_ratio = ratio;
        v.speed_joint = driven.joint;
        v.speed_time = t;
      }
      if (ratio > 1.0)
        since = std::min(since, t);
      else
        since = infinity;
      if (since < infinity && k + 1 < log.body.size())
        v.over_speed = std::max(v.over_speed, log.samples[k + 1].time - since);
    }
  }
}

void judge_clearance(const RunLog& log, Verdict::Body& v) {
  if (log.floating.apart.empty()) return;
  Clearance clearance(log.floating, 1);
  for (std::size_t k = 0; k < log.body.size(); ++k) {
    clearance.update(log.body[k].state, v.clearance);
    if (clearance.count() == 0) continue;
    v.clearance = clearance.approach(0).distance;
    v.clearance_pair = clearance.names(clearance.approach(0));
    v.clearance_time = log.samples[k].time;
  }
}

void judge_friction(const RunLog& log, Verdict::Body& v) {
  for (const Vec<double, 2>& used : friction_used(log)) v.friction = v.friction.cwiseMax(used);
  for (std::size_t k = 0; k + 1 < log.body.size(); ++k)
    for (const Vec<double, 6>& wrench : {log.body[k].left, log.body[k].right}) {
      if (wrench[2] <= 0.0) continue;
      const double most = log.ground_friction * wrench[2];
      v.beyond_friction += std::max(0.0, wrench.head<2>().norm() - most) *
                           (log.samples[k + 1].time - log.samples[k].time);
    }
}

void judge_slip(const RunLog& log, Verdict::Body& v) {
  const std::vector<Vec<double, 2>> slip = sole_slip(log);
  for (std::size_t k = 0; k < slip.size(); ++k)
    for (int foot = 0; foot < 2; ++foot) {
      v.slip[foot] = std::max(v.slip[foot], slip[k][foot]);
      if (slip[k][foot] > planted_slip)
        v.slips_from[foot] = std::min(v.slips_from[foot], log.samples[k].time);
    }
}

}  // namespace

bool Verdict::Body::touches_joint_limit() const { return limit_margin < limit_touched; }

Verdict::Body judge_body(const RunLog& log) {
  Verdict::Body v;
  const RunLog::BodySample& first = log.body.front();
  for (const RunLog::BodySample& b : log.body) {
    v.feet_moved =
        std::max({v.feet_moved, (b.left_sole.translation() - first.left_sole.translation()).norm(),
                  (b.right_sole.translation() - first.right_sole.translation()).norm()});
    v.tilt_max = std::max(v.tilt_max, angle_between(vertical(b), vertical(first)));
  }
  v.tilt_end = angle_between(vertical(log.body.back()), vertical(first));
  judge_slip(log, v);
  judge_friction(log, v);
  v.force_peak = peak_forces(log);
  judge_limits(log, v);
  judge_speeds(log, v);
  judge_clearance(log, v);
  v.excesses = hardware_excesses(log);
  v.lost_contacts = log.lost_contacts;
  v.landing_speed = landing_speed(log);
  for (const Vec<double, 12>& w : measured_wrenches(log))
    v.landing_force = std::max({v.landing_force, w[2], w[8]});
  v.standing = !log.stopped_early && log.touchdown == infinity && v.feet_moved < standing_move &&
               v.tilt_max < standing_tilt;
  return v;
}

nlohmann::ordered_json to_json(const Verdict::Body& v) {
  nlohmann::ordered_json excesses = nlohmann::ordered_json::array();
  for (const HardwareExcess& e : v.excesses)
    excesses.push_back({{"what", e.what},
                        {"unit", e.unit},
                        {"time_s", e.time},
                        {"first", e.first},
                        {"worst", e.worst},
                        {"limit", e.limit}});
  return {{"standing", v.standing},
          {"feet_moved_max_m", v.feet_moved},
          {"base_tilt_max_rad", v.tilt_max},
          {"base_tilt_end_rad", v.tilt_end},
          {"slip_max_m", v.slip.maxCoeff()},
          {"friction_max", v.friction.maxCoeff()},
          {"friction_beyond_ns", v.beyond_friction},
          {"joint_limit_touched", v.touches_joint_limit()},
          {"joint_limit_margin_rad", v.limit_margin},
          {"joint_limit_joint", v.limit_joint},
          {"joint_limit_time_s", v.limit_time},
          {"torque_limit_share", v.torque_limit_fraction},
          {"joint_speed_ratio_max", v.speed_ratio},
          {"joint_speed_joint", v.speed_joint},
          {"joint_speed_time_s", v.speed_time},
          {"joint_speed_over_s", v.over_speed},
          {"clearance_min_m", v.clearance},  // null without collision shapes
          {"clearance_pair", v.clearance_pair},
          {"clearance_time_s", v.clearance_time},
          {"landing_speed_m_s", v.landing_speed},
          {"landing_force_n", v.landing_force},
          {"lost_contacts", v.lost_contacts},
          {"hardware_excesses", std::move(excesses)}};
}

}  // namespace saltus::robots::walking
