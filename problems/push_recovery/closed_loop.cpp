#include "problems/push_recovery/closed_loop.hpp"

#include <algorithm>

#include "framework/ocp/window.hpp"

namespace saltus::push_recovery {
namespace {

constexpr double fallen_height = 0.30, fallen_distance = 1.0;  // m

}  // namespace

Scene initial_scene(const Config& config, const RobotDescription& robot) {
  Scene scene;
  scene.left_foot = robot.left_foot;
  scene.right_foot = robot.right_foot;
  scene.right.position = robot.default_posture().right_foot;
  scene.right.position[2] = 0.0;  // the ground is level
  scene.com_height = robot.default_posture().com[2];
  scene.target = config.target;
  return scene;
}

RobotDescription believed_robot(const Config& config, RobotDescription robot) {
  robot.mass *= 1.0 + config.mass_error;
  return robot;
}

Vec<double, 3> push_force(const Push& push) {
  return push.direction.normalized() * (push.impulse / push.duration);
}

bool is_pushed(const Push& push, double t) {
  const double into_push = t - push.start;
  return into_push > -same_instant && into_push < push.duration - same_instant;
}

bool has_fallen(const Vec<double, 9>& gamma) {
  return gamma[2] < fallen_height || gamma.head<2>().norm() > fallen_distance;
}

double end_time(const Push& push, const StepLogic& steps, double touchdown) {
  const double settled = rest_after + rest_length;
  if (touchdown < infinity) return touchdown + settled;
  return std::max(push.start + push.duration, steps.is_stepping() ? steps.landing_time() : 0.0) +
         settled;
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
  for (const SoftnessUse& use : plan.softness) r.softness = std::max(r.softness, use.largest);
  return r;
}

}  // namespace saltus::push_recovery
