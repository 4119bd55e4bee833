#include "saltus/robots/walking/hardware_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/robots/walking/body_forces.hpp"
#include "saltus/robots/walking/body_verdict.hpp"
#include "saltus/robots/whole_body/clearance.hpp"

namespace saltus::robots::walking {
namespace {

// Simulations keep to their limits up to rounding and the sampling of the log.
constexpr double slack = 1.01;

// The excesses, at most one for each quantity.
class Excesses {
 public:
  // The value exceeds the limit if `ratio` is above 1.
  void note(const std::string& what, const char* unit, double time, double value, double limit,
            double ratio) {
    if (!(ratio > 1.0)) return;
    const auto known = std::find_if(found_.begin(), found_.end(),
                                    [&what](const Found& f) { return f.excess.what == what; });
    if (known == found_.end()) {
      found_.push_back({{what, unit, time, value, value, limit}, ratio});
    } else if (ratio > known->ratio) {
      known->ratio = ratio;
      known->excess.worst = value;
    }
  }
  std::vector<HardwareExcess> by_time() {
    std::stable_sort(found_.begin(), found_.end(),
                     [](const Found& a, const Found& b) { return a.excess.time < b.excess.time; });
    std::vector<HardwareExcess> all;
    for (Found& f : found_) all.push_back(std::move(f.excess));
    return all;
  }

 private:
  struct Found {
    HardwareExcess excess;
    double ratio;
  };
  std::vector<Found> found_;
};

void check_feet(const RunLog& log, Excesses& all) {
  if (!log.robot.foot_sensor_range) return;
  static constexpr const char* names[] = {
      "horizontal force on the {} foot", "horizontal force on the {} foot",
      "vertical force on the {} foot",   "tipping moment on the {} foot",
      "tipping moment on the {} foot",   "turning moment on the {} foot"};
  const Vec<double, 6>& range = *log.robot.foot_sensor_range;
  const std::vector<Vec<double, 12>> wrenches = measured_wrenches(log);
  for (std::size_t k = 0; k < wrenches.size(); ++k)
    for (int i = 0; i < 12; ++i) {
      const double value = std::abs(wrenches[k][i]), limit = range[i % 6];
      if (value > limit)
        all.note(fmt::format(fmt::runtime(names[i % 6]), name_of(i < 6 ? Side::left : Side::right)),
                 i % 6 < 3 ? "N" : "Nm", log.samples[k].time, value, limit, value / limit);
    }
}

void check_joints(const RunLog& log, Excesses& all) {
  for (int i = 0; i < log.floating.joints(); ++i) {
    const FloatingRobot::Body& driven = log.floating.bodies[static_cast<std::size_t>(i) + 1];
    for (std::size_t k = 0; k < log.body.size(); ++k) {
      const WholeBodyState& now = log.body[k].state;
      const WholeBodyState& next = log.body[std::min(k + 1, log.body.size() - 1)].state;
      const double t = log.samples[k].time;
      const double speed = std::abs(now.dq[i]);
      if (speed > driven.velocity)
        all.note("speed of " + driven.joint, "rad/s", t, speed, driven.velocity,
                 speed / driven.velocity);
      const double outside =
          std::max(driven.position.lower - now.q[i], now.q[i] - driven.position.upper);
      if (outside > limit_touched)
        all.note("position of " + driven.joint + " beyond its limit", "rad", t, outside, 0.0,
                 1.0 + outside);
      // The speed during the sample lies between those at its ends.
      const double torque = log.body[k].torques[i];
      const Bounds ranges[] = {driven.drive.torque_range(driven.effort, now.dq[i]),
                               driven.drive.torque_range(driven.effort, next.dq[i])};
      const double most = torque > 0.0 ? std::max(ranges[0].upper, ranges[1].upper)
                                       : -std::min(ranges[0].lower, ranges[1].lower);
      if (std::abs(torque) > slack * most)
        all.note("torque of " + driven.joint + " at its speed", "Nm", t, std::abs(torque), most,
                 1.0 + (std::abs(torque) - most) / driven.effort);
    }
  }
}

void check_limbs(const RunLog& log, Excesses& all) {
  if (log.floating.apart.empty()) return;
  Clearance clearance(log.floating, 1);
  for (std::size_t k = 0; k < log.body.size(); ++k) {
    clearance.update(log.body[k].state, 0.0);
    if (clearance.count() == 0) continue;
    const double overlap = -clearance.approach(0).distance;
    all.note("overlap of " + clearance.names(clearance.approach(0)), "m", log.samples[k].time,
             overlap, 0.0, 1.0 + overlap);
  }
}

}  // namespace

std::vector<HardwareExcess> hardware_excesses(const RunLog& log) {
  Excesses all;
  if (log.body.empty()) return {};
  check_feet(log, all);
  check_joints(log, all);
  check_limbs(log, all);
  return all.by_time();
}

std::string describe(const HardwareExcess& excess) {
  return fmt::format("at {:.3f} s the {} was {:.4g} {} (limit {:.4g})", excess.time, excess.what,
                     excess.first, excess.unit, excess.limit);
}

double landing_speed(const RunLog& log) {
  double fastest = 0.0;
  for (std::size_t k = 2; k < log.body.size(); ++k) {
    const double period = log.samples[k - 1].time - log.samples[k - 2].time;
    const auto touch = [&](const Vec<double, 6>& before, const Vec<double, 6>& now,
                           const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
      if (before[2] == 0.0 && now[2] > 0.0)
        fastest = std::max(fastest, (from.translation() - to.translation())[2] / period);
    };
    const RunLog::BodySample &a = log.body[k - 2], &b = log.body[k - 1], &c = log.body[k];
    touch(b.left, c.left, a.left_sole, b.left_sole);
    touch(b.right, c.right, a.right_sole, b.right_sole);
  }
  return fastest;
}

}  // namespace saltus::robots::walking
