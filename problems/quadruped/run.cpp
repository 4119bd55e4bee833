#include "problems/quadruped/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "saltus/app/defer_signals.hpp"

namespace saltus::quadruped {
namespace {

const std::vector<std::string> state_names{"x [m]",     "y [m]",      "z [m]",      "vx [m/s]",
                                           "vy [m/s]",  "vz [m/s]",   "roll [rad]", "pitch [rad]",
                                           "yaw [rad]", "wx [rad/s]", "wy [rad/s]", "wz [rad/s]"};

std::vector<std::string> input_names() {
  std::vector<std::string> names;
  for (const char* leg : leg_names)
    for (const char axis : {'x', 'y', 'z'}) names.push_back(fmt::format("{} f{} [N]", leg, axis));
  return names;
}

// Standard deviations of a good estimator.
State<double> measurement_noise() {
  State<double> noise;
  noise << Vec<double, 3>::Constant(2e-3), Vec<double, 3>::Constant(0.02),
      Vec<double, 3>::Constant(0.005), Vec<double, 3>::Constant(0.05);
  return noise;
}

}  // namespace

RunLog run(const Config& config) {
  ControllerSettings settings = config.controller;
  apply_gait(config.gait, settings.gait);
  RobotOnGround robot(
      config.plant,
      Ground(config.scale * config.roughness, static_cast<std::uint64_t>(config.seed)),
      settings.height);
  Controller controller(settings);

  RunLog result;
  LoopOptions options{.duration = config.duration};
  options.state_names = state_names;
  options.input_names = input_names();
  const double towards = config.towards * std::numbers::pi / 180.0;
  options.disturbances.pulses = {config.push};
  options.disturbances.pulses[0].impulse *= config.scale;
  options.disturbances.pulses[0].direction =
      Vec<double, 3>(std::cos(towards), std::sin(towards), 0.0);
  options.disturbances.seed = static_cast<std::uint64_t>(config.seed);
  if (config.noise > 0.0)
    options.disturbances.measurement_noise = config.noise * measurement_noise();
  options.before_tick = [&](double now, const VectorRef& measured) {
    controller.observe(now, measured, robot.feet(), robot.touching());
    robot.command(controller.commands());
    Row row{now, robot.feet(), robot.forces(), robot.touching(), {}, robot.tilt(), robot.height()};
    for (int leg = 0; leg < legs; ++leg) row.planned[leg] = controller.gait().stands(leg);
    result.farthest = std::max(result.farthest, row.tilt);
    result.rows.push_back(row);
  };
  options.until = [&](double, const VectorRef&) {
    result.fell = robot.tilt() > fallen_tilt || robot.height() < fallen_height;
    return result.fell || DeferSignals::received() != 0;
  };
  result.log = simulate_closed_loop(controller.planner(), robot, options);
  if (!result.log.completed) result.fell = true;
  result.early = controller.gait().early();
  result.late = controller.gait().late();
  result.waited = controller.gait().waited();
  return result;
}

Config disturbed(const Config& config, int i, bool blind) {
  Config one = config;
  one.seed = config.seed + i;
  Random random(static_cast<std::uint64_t>(one.seed) + 1000);
  one.towards = random.uniform(0.0, 360.0);
  one.push.start = random.uniform(1.5, 2.5);
  one.controller.gait.blind = blind;
  return one;
}

}  // namespace saltus::quadruped
