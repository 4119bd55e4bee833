#include "problems/push_recovery/criteria.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/walking/push.hpp"

namespace saltus::push_recovery {
namespace {

// Reason of a failure: time (s), description, and value.
struct Cause {
  double time = infinity;
  std::string happened, extent;
};

// The first sample in which a quantity exceeds its limit.
template <class Beyond>
double first_time(const RunLog& log, Beyond beyond) {
  const auto found = std::find_if(log.samples.begin(), log.samples.end(), beyond);
  return found == log.samples.end() ? infinity : found->time;
}

// Violations of the limits for the whole run.
std::vector<Cause> causes_on_the_way(const RunLog& log, const Verdict& v,
                                     const LimitsOnTheWay& limits) {
  std::vector<Cause> causes;
  const double lowest = limits.height.lower, highest = limits.height.upper,
               largest = limits.momentum;
  causes.push_back({first_time(log, [=](const BipedSample& s) { return s.gamma[2] < lowest; }),
                    fmt::format("the CoM sank below {:.2f} m", lowest),
                    fmt::format("the CoM sank to {:.3f} m", v.com_height_min)});
  causes.push_back({first_time(log, [=](const BipedSample& s) { return s.gamma[2] > highest; }),
                    fmt::format("the CoM rose above {:.2f} m", highest),
                    fmt::format("the CoM rose to {:.3f} m", v.com_height_max)});
  causes.push_back(
      {first_time(log, [=](const BipedSample& s) { return s.gamma.tail<3>().norm() > largest; }),
       fmt::format("the angular momentum exceeded {:.2g} Nms", largest),
       fmt::format("the angular momentum reached {:.2f} Nms", v.angular_momentum_max)});
  if (v.body)
    for (int foot = 0; foot < 2; ++foot) {
      const char* side = name_of(foot == 0 ? robots::Side::left : robots::Side::right);
      causes.push_back(
          {v.body->slips_from[foot], fmt::format("the {} foot slipped", side),
           fmt::format("the {} foot slipped by {:.0f} mm", side, 1e3 * v.body->slip[foot])});
    }
  return causes;
}

// The first criterion of rest that a sample violates, or an empty string.
std::string unrest(const BipedSample& s, const robots::SupportPolygon& ground,
                   const Vec<double, 2>& target, double momentum) {
  if (!ground.contains(s.capture_point)) return "the capture point left the support polygon";
  if (s.gamma.segment<3>(3).norm() > rest_speed) return "the CoM did not come to rest";
  if ((s.gamma.head<2>() - target).norm() > rest_com_error) return "the CoM missed its target";
  if (s.gamma.tail<3>().norm() > rest_angular_momentum * momentum)
    return "the angular momentum did not decay";
  return {};
}

}  // namespace

double end_time(double push_end, double landing, double touchdown) {
  const double last = landing < infinity ? landing : touchdown < infinity ? touchdown : 0.0;
  return std::max(push_end, last) + rest_after + rest_length;
}

LimitsOnTheWay limits_on_the_way(const Config& config, const robots::RobotDescription& robot) {
  LimitsOnTheWay limits;
  if (robot.postures.empty()) return limits;
  // The bounds are those of a robot on one foot.
  const robots::StandingPosture& one_foot = config.scene.stance == robots::Stance::both
                                                ? robot.default_posture()
                                                : posture_at_start(config.scene, robot);
  const double length = one_foot.com[2] / reference_height;
  limits.height = between(height_lowest * length, height_highest * length);
  limits.momentum = angular_momentum_limit * robot.mass / reference_mass * std::pow(length, 1.5);
  return limits;
}

Verdict judge(const Config& config, const RunLog& log) {
  const std::vector<Push> pushes = all_pushes(config.push, config.more_pushes);
  double settled_from = log.last_touchdown() < infinity ? log.last_touchdown() : 0.0;
  for (const Push& push : pushes) settled_from = std::max(settled_from, push.end());
  Verdict v = figures_of(log, settled_from, pushes);
  const LimitsOnTheWay limits = limits_on_the_way(config, log.robot);
  const double momentum = limits.momentum / angular_momentum_limit;  // 1 for iCub
  std::vector<Cause> causes = causes_on_the_way(log, v, limits);
  const Scene& scene = log.final_scene;
  const robots::SupportPolygon ground =
      log.samples.back().two_feet() ? scene.hull() : scene.stance_polygon();
  const Vec<double, 2> target = scene.target_point();
  for (const BipedSample& s : log.samples)
    if (s.time >= settled_from + rest_after - same_instant) {
      const std::string reason = unrest(s, ground, target, momentum);
      if (reason.empty()) continue;
      causes.push_back({s.time, reason, reason});
      break;
    }
  const Cause& first = *std::min_element(
      causes.begin(), causes.end(), [](const Cause& a, const Cause& b) { return a.time < b.time; });
  if (first.time < infinity) {
    if (!log.stopped_early)
      v.fail(first.extent);
    else if (first.time < log.samples.back().time)
      v.reason += fmt::format("; first, at {:.2f} s, {}", first.time, first.happened);
  }
  v.recovered = v.reason.empty();
  return v;
}

}  // namespace saltus::push_recovery
