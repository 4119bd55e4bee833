#include "saltus/robots/walking/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/integrators/cvodes.hpp"
#include "saltus/ocp/window.hpp"
#include "saltus/robots/centroidal/centroidal_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/capture_point_controller.hpp"
#include "saltus/robots/walking/closed_loop.hpp"

namespace saltus::push_recovery {
namespace {

// The plant is the truth: far tighter than anything that is compared with it.
constexpr double plant_tolerance = 1e-11;

class ClosedLoop {
 public:
  ClosedLoop(const Config& config, const RobotDescription& robot)
      : config_(config),
        nominal_mass_(nominal_robot(config, robot).mass),
        scene_(initial_scene(config, robot)),
        steps_(config.step, config.stepping, config.push.start, scene_.side, scene_.stance,
               scene_.stance_foot),
        plant_(robot.mass, start_state(robot.posture_on(config.stance)),
               cvodes({.method = CvodesMethod::Adams,
                       .tolerance = plant_tolerance,
                       .absolute_tolerance = plant_tolerance})),
        planner_(
            config.controller == ControllerChoice::mpc
                ? make_mpc(config, nominal_robot(config, robot), scene_)
                : make_capture_point_controller(config, nominal_robot(config, robot), scene_)) {
    log_.robot = robot;
    plant_.foot(scene_.side) = {scene_.stance, true};
    swing_foot() = {scene_.swing, false};
    applied_[scene_.side == Side::left ? 2 : 8] = robot.mass * standard_gravity;
  }

  RunLog run(const Observer& observer) {
    const double h = config_.mpc_step;
    for (long k = 0; !log_.stopped_early; ++k) {
      const double t = static_cast<double>(k) * h;
      if (t > end_time(config_.push, steps_, log_.touchdown) - same_instant) break;
      if (observer)
        observer(loop_state(config_.push, t, plant_.state(), scene_, steps_, log_.touchdown));
      tick(t);
    }
    record(now_);
    log_.final_scene = scene_;
    log_.loop = planner_->controller().statistics();
    log_.solver = planner_->controller().solver_name();
    return std::move(log_);
  }

 private:
  static Vec<double, 9> start_state(const StandingPosture& posture) {
    Vec<double, 9> gamma = Vec<double, 9>::Zero();
    gamma.head<3>() = posture.com;
    return gamma;
  }

  CentroidalPlant::Foot& swing_foot() { return plant_.foot(other(scene_.side)); }

  void tick(double t) {
    const Vec<double, 9> gamma = plant_.state();
    const double omega = frequency_of_height(gamma[2]);
    steps_.update(t,
                  capture_point_at_rest(gamma.head<3>(), gamma.segment<3>(3), gamma.tail<3>(),
                                        nominal_mass_, omega),
                  omega);
    if (steps_.is_stepping() && log_.touchdown == infinity) {
      scene_.swing.position = steps_.place();
      scene_.two_feet = true;
    }
    const Measurement measured{t, gamma, reordered(scene_.side, applied_),
                               plant_.contact_force(applied_)};
    const ControlTick& control = planner_->tick(measured, scene_, steps_.landing_time());
    log_.ticks.push_back(tick_record(t, control, planner_->controller()));
    for (const InputPiece& piece : control.input) {
      applied_ = reordered(scene_.side, piece.input());
      apply(piece);
      if (log_.stopped_early) return;
    }
  }

  // Cuts the piece where the push begins or ends and where the foot lands.
  void apply(const InputPiece& piece) {
    const double end = piece.start + piece.length;
    double t = piece.start;
    while (end - t > same_instant) {
      double next = end;
      for (const double edge :
           {config_.push.start, config_.push.start + config_.push.duration, steps_.landing_time()})
        if (edge - t > same_instant && edge < next - same_instant) next = edge;
      enter(t, next);
      record(t);
      const IntegrationStatus status = plant_.advance(next - t, applied_);
      if (status != IntegrationStatus::success) {
        log_.numerical_failure = true;
        return stop(
            fmt::format("the plant could not be integrated at {:.3f} s: {}", t, describe(status)));
      }
      now_ = t = next;
      const Vec<double, 9>& gamma = plant_.state();
      if (has_fallen(gamma, scene_.com_height)) return stop(fall_sentence(config_.push, t));
    }
  }

  // What holds from time t on, up to `next`.
  void enter(double t, double next) {
    plant_.push = mean_push_force(config_.push, t, next);
    if (!swing_foot().in_contact && t > steps_.landing_time() - same_instant) {
      swing_foot() = {scene_.swing, true};
      log_.touchdown = t;
    }
  }

  void record(double t) {
    const Vec<double, 9>& gamma = plant_.state();
    const double omega = frequency_of_height(gamma[2]);
    Sample sample{t,
                  gamma,
                  capture_point<double, 2>(gamma.head<2>(), gamma.segment<2>(3), omega),
                  applied_,
                  plant_.push,
                  swing_foot().in_contact};
    log_.samples.push_back(std::move(sample));
  }

  void stop(std::string reason) {
    log_.stopped_early = true;
    log_.stop_reason = std::move(reason);
  }

  const Config& config_;
  double nominal_mass_;  // by the controllers
  Scene scene_;
  StepLogic steps_;
  CentroidalPlant plant_;
  std::unique_ptr<Planner> planner_;
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
  double now_ = 0.0;
  RunLog log_;
};

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

SupportPolygon ground_of(const Scene& scene, bool two_feet) {
  return two_feet ? scene.hull() : SupportPolygon::under({{scene.stance, scene.stance_foot}});
}

}  // namespace

RunLog simulate(const Config& config, const RobotDescription& robot, const Observer& observer) {
  return ClosedLoop(config, robot).run(observer);
}

Verdict judge(const Config& config, const RunLog& log) {
  Verdict v;
  for (const Sample& s : log.samples) {
    v.com_height_min = std::min(v.com_height_min, s.gamma[2]);
    v.com_height_max = std::max(v.com_height_max, s.gamma[2]);
    v.angular_momentum_max = std::max(v.angular_momentum_max, s.gamma.tail<3>().norm());
  }
  const Sample& last = log.samples.back();
  const bool two_feet = last.two_feet;
  const Vec<double, 2> target = log.final_scene.target_point();
  v.final_com_error = (last.gamma.head<2>() - target).norm();

  const double settled_from =
      log.touchdown < infinity ? log.touchdown : config.push.start + config.push.duration;
  v.icp_settling = 0.0;
  for (const Sample& s : log.samples)
    if (s.time >= settled_from &&
        (s.capture_point - last.capture_point).norm() > icp_settled_within)
      v.icp_settling = s.time - settled_from;

  const auto fail = [&](std::string reason) {
    if (v.reason.empty()) v.reason = std::move(reason);
  };
  if (log.stopped_early) {
    v.icp_settling = infinity;
    fail(log.stop_reason);
  }
  double length = 1.0, momentum = 1.0;
  if (!log.robot.postures.empty()) {
    length = log.robot.posture_on(config.stance).com[2] / reference_height;
    momentum = log.robot.mass / reference_mass * std::pow(length, 1.5);
  }
  if (v.com_height_min < height_lowest * length)
    fail(fmt::format("the CoM sank to {:.3f} m", v.com_height_min));
  if (v.com_height_max > height_highest * length)
    fail(fmt::format("the CoM rose to {:.3f} m", v.com_height_max));
  if (v.angular_momentum_max > angular_momentum_limit * momentum)
    fail(fmt::format("the angular momentum reached {:.2f} Nms", v.angular_momentum_max));
  const SupportPolygon ground = ground_of(log.final_scene, two_feet);
  for (const Sample& s : log.samples)
    if (s.time >= settled_from + rest_after - same_instant) {
      const std::string reason = unrest(s, ground, target, momentum);
      if (!reason.empty()) fail(reason);
    }
  if (!log.body.empty()) {
    v.body = judge_body(log);
    for (int foot = 0; foot < 2; ++foot)
      if (v.body->slip[foot] > planted_slip)
        fail(fmt::format("the {} foot slipped by {:.0f} mm", foot == 0 ? "left" : "right",
                         1e3 * v.body->slip[foot]));
  }
  v.fell_before_push = log.stopped_early && !log.numerical_failure && last.time < config.push.start;
  v.recovered = v.reason.empty();
  return v;
}

}  // namespace saltus::push_recovery
