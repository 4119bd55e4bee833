#include "saltus/robots/walking/closed_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "saltus/ocp/window.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace saltus::push_recovery {
namespace {

constexpr double fallen_height = 0.30, fallen_distance = 1.0;  // m

}  // namespace

Scene initial_scene(const Config& config, const RobotDescription& robot) {
  Scene scene;
  const StandingPosture& posture = robot.posture_on(config.stance);
  scene.side = config.stance;
  scene.stance_foot = robot.foot(scene.side);
  scene.swing_foot = robot.foot(other(scene.side));
  scene.swing.position = posture.other_foot;
  scene.swing.position[2] = 0.0;  // the ground is level
  scene.com_height = posture.com[2];
  scene.target = config.target;
  return scene;
}

RobotDescription nominal_robot(const Config& config, RobotDescription robot) {
  robot.mass *= 1.0 + config.mass_error;
  return robot;
}

double push_share(const Push& push, double t) {
  const double s = std::clamp((t - push.start) / push.duration, 0.0, 1.0);
  switch (push.shape) {
    case PushShape::rectangle:
      return s;
    case PushShape::half_sine:
      return 0.5 * (1.0 - std::cos(std::numbers::pi * s));
    case PushShape::triangle:
      return s < 0.5 ? 2.0 * s * s : 1.0 - 2.0 * (1.0 - s) * (1.0 - s);
  }
  return s;
}

Vec<double, 3> mean_push_force(const Push& push, double from, double to) {
  const double end = push.start + push.duration;
  if (to < push.start + same_instant || from > end - same_instant) return Vec<double, 3>::Zero();
  const Vec<double, 3> direction = push.direction.normalized();
  const bool within = from > push.start - same_instant && to < end + same_instant;
  if (push.shape == PushShape::rectangle && within)
    return direction * (push.impulse / push.duration);  // without rounding
  const double share = push_share(push, to) - push_share(push, from);
  return direction * (push.impulse * share / (to - from));
}

bool has_fallen(const Vec<double, 9>& gamma, double com_height) {
  const double size = com_height / reference_height;
  return !(gamma[2] >= fallen_height * size && gamma.head<2>().norm() <= fallen_distance * size);
}

std::string fall_sentence(const Push& push, double t) {
  return fmt::format("fell at {:.2f} s{}", t, t < push.start ? ", before the push" : "");
}

double end_time(const Push& push, const StepLogic& steps, double touchdown) {
  const double settled = rest_after + rest_length;
  if (touchdown < infinity) return touchdown + settled;
  return std::max(push.start + push.duration, steps.is_stepping() ? steps.landing_time() : 0.0) +
         settled;
}

LoopState loop_state(const Push& push, double t, const Vec<double, 9>& gamma, const Scene& scene,
                     const StepLogic& steps, double touchdown) {
  const bool landed = touchdown < infinity;
  const SupportPolygon ground =
      landed ? scene.hull() : SupportPolygon::under({{scene.stance, scene.stance_foot}});
  const double omega = frequency_of_height(gamma[2]);
  LoopState state{t, gamma[2]};
  state.margin = -ground.signed_distance(
      capture_point<double, 2>(gamma.head<2>(), gamma.segment<2>(3), omega));
  const bool pushed = t > push.start - same_instant && t < push.start + push.duration;
  state.footing = landed                ? Footing::landed
                  : steps.is_stepping() ? Footing::stepping
                  : pushed              ? Footing::pushed
                                        : Footing::standing;
  return state;
}

TickRecord tick_record(double t, const ControlTick& tick, RecedingHorizonController& controller) {
  TickRecord r;
  r.time = t;
  r.provenance = tick.provenance;
  const Solution plan = controller.report();
  r.status = plan.status;
  r.message = plan.message;
  r.seconds = tick.seconds;
  r.iterations = plan.iterations;
  r.cost = plan.cost;
  r.kkt = plan.kkt.scaled();
  for (const SoftViolation& use : plan.soft_violations)
    r.softness = std::max(r.softness, use.largest);
  return r;
}

}  // namespace saltus::push_recovery
