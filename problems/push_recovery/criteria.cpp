#include "problems/push_recovery/criteria.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/ocp/window.hpp"

namespace saltus::push_recovery {
namespace {

// The first criterion that a sample at rest misses, or an empty string.
std::string unrest(const Sample& s, const SupportPolygon& ground, const Vec<double, 2>& target,
                   double momentum) {
  if (!ground.contains(s.capture_point)) return "the capture point left the support polygon";
  if (s.gamma.segment<3>(3).norm() > rest_speed) return "the CoM did not come to rest";
  if ((s.gamma.head<2>() - target).norm() > rest_com_error) return "the CoM missed its target";
  if (s.gamma.tail<3>().norm() > rest_angular_momentum * momentum)
    return "angular momentum did not die away";
  return {};
}

}  // namespace

double end_time(const Push& push, const StepPlanner& steps, double touchdown) {
  const double settled = rest_after + rest_length;
  if (touchdown < infinity) return touchdown + settled;
  return std::max(push.end(), steps.is_stepping() ? steps.landing_time() : 0.0) + settled;
}

Verdict judge(const Config& config, const RunLog& log) {
  const double settled_from = log.touchdown < infinity ? log.touchdown : config.push.end();
  Verdict v = figures_of(log, settled_from, {&config.push, 1});
  double length = 1.0, momentum = 1.0;
  if (!log.robot.postures.empty()) {
    length = log.robot.posture_on(config.scene.stance).com[2] / reference_height;
    momentum = log.robot.mass / reference_mass * std::pow(length, 1.5);
  }
  if (v.com_height_min < height_lowest * length)
    v.fail(fmt::format("the CoM sank to {:.3f} m", v.com_height_min));
  if (v.com_height_max > height_highest * length)
    v.fail(fmt::format("the CoM rose to {:.3f} m", v.com_height_max));
  if (v.angular_momentum_max > angular_momentum_limit * momentum)
    v.fail(fmt::format("the angular momentum reached {:.2f} Nms", v.angular_momentum_max));
  const Scene& scene = log.final_scene;
  const SupportPolygon ground = log.samples.back().two_feet ? scene.hull() : scene.stance_polygon();
  const Vec<double, 2> target = scene.target_point();
  for (const Sample& s : log.samples)
    if (s.time >= settled_from + rest_after - same_instant) {
      const std::string reason = unrest(s, ground, target, momentum);
      if (!reason.empty()) v.fail(reason);
    }
  if (v.body)
    for (int foot = 0; foot < 2; ++foot)
      if (v.body->slip[foot] > planted_slip)
        v.fail(fmt::format("the {} foot slipped by {:.0f} mm", foot == 0 ? "left" : "right",
                           1e3 * v.body->slip[foot]));
  v.recovered = v.reason.empty();
  return v;
}

}  // namespace saltus::push_recovery
