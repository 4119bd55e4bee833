#include "saltus/robots/walking/full_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/clock.hpp"
#include "saltus/ocp/window.hpp"
#include "saltus/robots/dart/dart_dynamics.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "saltus/robots/walking/capture_point_controller.hpp"
#include "saltus/robots/walking/closed_loop.hpp"
#include "saltus/robots/whole_body/inverse_dynamics_controller.hpp"
#include "saltus/robots/whole_body/swing_foot.hpp"

namespace saltus::push_recovery {
namespace {

// A foot has landed when the ground carries this much, N, in the second half of its swing.
constexpr double landed_force = 20.0;

// Adds the CPU time of its life to a sum.
class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds) {}
  ~Stopwatch() { seconds_ += 1e-6 * (thread_microseconds() - begin_); }

 private:
  double& seconds_;
  double begin_ = thread_microseconds();
};

class FullBodyLoop {
 public:
  FullBodyLoop(const Config& config, const RobotDescription& robot,
               const std::filesystem::path& urdf)
      : config_(config),
        model_(UrdfModel::read(urdf)),
        body_(floating_robot(model_, robot)),
        scene_(initial_scene(config, robot)),
        steps_(config.step, config.stepping, config.push.start, scene_.side, scene_.stance,
               scene_.stance_foot),
        nominal_(with_masses_scaled(body_, 1.0 + config.mass_error)),
        dynamics_(make_dart_dynamics(nominal_)),
        plant_(make_plant(body_, config), config.noise, config.delay_ticks),
        planner_(config.controller == ControllerChoice::mpc
                     ? make_mpc(config, nominal_robot(config, robot), scene_)
                     : make_capture_point_controller(config, nominal_robot(config, robot), scene_)),
        controller_(make_whole_body_controller(nominal_, config, robot)) {
    log_.robot = robot;
    log_.floating = body_;
    log_.pushed = link_frame(body_, model_, config.push.link);
    log_.pushed.pose.translate(config.push.point);
    const WholeBodyState start =
        standing_state(body_, model_, robot, robot.posture_on(config.stance));
    if (!config.noise.is_zero() || config.mass_error != 0.0) truth_ = make_dart_dynamics(body_);
    plant_.reset(start);
    update_dynamics();
    swing_.hold(dynamics_->sole(swing_side()).pose);
    swing_stands() = false;
    tasks_.posture = start.q;
    applied_[scene_.side == Side::left ? 2 : 8] = nominal_.total_mass * standard_gravity;
  }

  RunLog run(const Observer& observer) {
    const long per_control = std::lround(config_.control_period / config_.plant_step);
    const long per_plan = std::lround(config_.mpc_step / config_.plant_step);
    for (long k = 0; !log_.stopped_early; ++k) {
      const double t = static_cast<double>(k) * config_.plant_step;
      if (t > end_time(config_.push, steps_, log_.touchdown) - same_instant) break;
      if (k % per_control == 0) update_dynamics();
      detect_landing(t);
      if (k % per_plan == 0) {
        if (observer)
          observer(loop_state(config_.push, t, gamma(truth()), scene_, steps_, log_.touchdown));
        plan(t);
        log_.ticks.push_back(tick_record(t, *tick_, planner_->controller()));
      }
      if (k % per_control == 0) control(t);
      step(t);
      if (k % per_control == 0) record(t);
    }
    log_.final_scene = scene_;
    if (has_landed()) log_.final_scene.swing.position = landed_at_;
    log_.loop = planner_->controller().statistics();
    log_.solver = planner_->controller().solver_name();
    log_.plant = plant_.name();
    return std::move(log_);
  }

 private:
  static std::unique_ptr<WholeBodyController> make_whole_body_controller(
      const FloatingRobot& body, const Config& config, const RobotDescription& robot) {
    const ContactConeOptions left = contact_options(config, robot.left_foot);
    const ContactConeOptions right = contact_options(config, robot.right_foot);
    if (config.whole_body_controller == WholeBodyChoice::momentum)
      return make_momentum_controller(body, left, right, config.momentum);
    return make_inverse_dynamics_controller(body, left, right, config.whole_body);
  }

  static std::unique_ptr<Plant> make_plant(const FloatingRobot& robot, const Config& config) {
    DartOptions options;
    options.step = config.plant_step;
    options.friction = config.ground_friction;
    options.ground_step = config.ground_step;
    options.ground_edge = (config.stance == Side::left ? -1.0 : 1.0) * config.ground_edge;
    options.joint_friction = config.joint_friction;
    options.collision = config.collision;
    options.lcp = config.lcp;
    if (config.plant == PlantChoice::mujoco) return make_mujoco_plant(robot, options);
    return make_dart_plant(robot, options);
  }

  Side swing_side() const { return other(scene_.side); }
  bool& swing_stands() {
    return swing_side() == Side::left ? tasks_.left_stands : tasks_.right_stands;
  }
  bool has_landed() const { return log_.touchdown < infinity; }
  // While the foot is late the landing is held just ahead.
  double impact_time(double t) const {
    if (has_landed()) return log_.touchdown;
    return std::max(steps_.landing_time(), t + config_.mpc_step);
  }

  // The controllers' model at what is measured; the truth, for the log, where that differs.
  void update_dynamics() {
    {
      Stopwatch watch(log_.control_seconds);
      dynamics_->update(plant_.state());
    }
    if (truth_ != nullptr) truth_->update(plant_.truth().state());
  }
  const DynamicsModel& truth() const { return truth_ != nullptr ? *truth_ : *dynamics_; }

  static Vec<double, 9> gamma(const DynamicsModel& model) {
    Vec<double, 9> g;
    g << model.com(), model.com_velocity(), model.angular_momentum();
    return g;
  }

  void detect_landing(double t) {
    if (!swing_.is_under_way() || has_landed()) return;
    const FootContact& contact = plant_.contact(swing_side());
    const double half = steps_.landing_time() - 0.5 * config_.step.duration;
    if (t < half || contact.wrench[2] < landed_force) return;
    log_.touchdown = t;
    scene_.swing.position = dynamics_->sole(swing_side()).pose.translation();
    landed_at_ = truth().sole(swing_side()).pose.translation();
    swing_stands() = true;
  }

  void plan(double t) {
    Stopwatch watch(log_.plan_seconds);
    const Vec<double, 9> measured = gamma(*dynamics_);
    const double omega = frequency_of_height(measured[2]);
    steps_.update(t,
                  capture_point_at_rest(measured.head<3>(), measured.segment<3>(3),
                                        measured.tail<3>(), dynamics_->mass(), omega),
                  omega);
    if (steps_.is_stepping() && !has_landed()) {
      if (!swing_.is_under_way()) swing_.start(t, steps_.landing_time());
      scene_.swing.position = steps_.place();
      scene_.two_feet = true;
      swing_.aim(steps_.landing_time(), steps_.place());
    }
    Vec<double, 3> force = Vec<double, 3>::Zero();
    force += dynamics_->sole(Side::left).pose.linear() * applied_.segment<3>(0);
    force += dynamics_->sole(Side::right).pose.linear() * applied_.segment<3>(6);
    const Measurement m{t, measured, reordered(scene_.side, applied_), force};
    tick_ = &planner_->tick(m, scene_, impact_time(t));
  }

  void control(double t) {
    Stopwatch watch(log_.control_seconds);
    const InputPiece* piece = &tick_->input[0];
    for (const InputPiece& p : tick_->input)
      if (p.start <= t + same_instant) piece = &p;
    tasks_.wrenches = reordered(scene_.side, piece->input());
    tasks_.force = Vec<double, 3>(0.0, 0.0, -nominal_.total_mass * standard_gravity);
    tasks_.torque.setZero();
    for (const Side side : {Side::left, Side::right}) {
      const int first = side == Side::left ? 0 : 6;
      if (side == swing_side() && !swing_stands()) tasks_.wrenches.segment<6>(first).setZero();
      const SoleMotion& sole = dynamics_->sole(side);
      const Vec<double, 3> f = sole.pose.linear() * tasks_.wrenches.segment<3>(first);
      tasks_.force += f;
      tasks_.torque += sole.pose.linear() * tasks_.wrenches.segment<3>(first + 3) +
                       (sole.pose.translation() - dynamics_->com()).cross(f);
    }
    swing_.advance(t);
    tasks_.swing_acceleration = swing_.acceleration(dynamics_->sole(swing_side()));
    const WholeBodyCommand& command = controller_->control(*dynamics_, plant_.state(), tasks_);
    if (command.status != QpStatus::optimal) ++log_.control_failures;
    if (command.torques_cut > 0) ++log_.control_cuts;
    ++log_.control_calls;
    command_ = &command;
    plant_.set_torques(command.torques);
    applied_ = command.wrenches;
  }

  void step(double t) {
    Stopwatch watch(log_.plant_seconds);
    pushed_ = mean_push_force(config_.push, t, t + config_.plant_step);
    if (!pushed_.isZero(0.0))
      plant_.push(log_.pushed.body, pushed_, log_.pushed.pose.translation());
    before_ = plant_.truth().state();
    plant_.step();
    if (!plant_.truth().state().is_finite()) {
      log_.numerical_failure = true;
      stop(fmt::format("the plant could not be integrated at {:.3f} s", t));
    }
  }

  void record(double t) {
    const Vec<double, 9> g = gamma(truth());
    const double omega = frequency_of_height(g[2]);
    Sample s{t,        g,       capture_point<double, 2>(g.head<2>(), g.segment<2>(3), omega),
             applied_, pushed_, has_landed()};
    log_.samples.push_back(std::move(s));
    BodySample b;
    b.planned = tasks_.wrenches;
    b.state = before_;
    b.torques = command_->torques;
    b.left = plant_.truth().contact(Side::left).wrench;
    b.right = plant_.truth().contact(Side::right).wrench;
    b.left_sole = truth().sole(Side::left).pose;
    b.right_sole = truth().sole(Side::right).pose;
    log_.body.push_back(std::move(b));
    if (has_fallen(g, scene_.com_height)) stop(fall_sentence(config_.push, t));
  }

  void stop(std::string reason) {
    log_.stopped_early = true;
    log_.stop_reason = std::move(reason);
  }

  const Config& config_;
  UrdfModel model_;
  FloatingRobot body_;
  Vec<double, 3> pushed_ = Vec<double, 3>::Zero();
  Scene scene_;
  StepLogic steps_;
  FloatingRobot nominal_;  // by the controllers
  std::unique_ptr<DynamicsModel> dynamics_, truth_;
  MeasuredPlant plant_;
  std::unique_ptr<Planner> planner_;
  std::unique_ptr<WholeBodyController> controller_;
  SwingFoot swing_;
  WholeBodyTasks tasks_;
  WholeBodyState before_;  // of the last step
  Vec<double, 3> landed_at_ = Vec<double, 3>::Zero();
  const ControlTick* tick_ = nullptr;
  const WholeBodyCommand* command_ = nullptr;
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
  RunLog log_;
};

}  // namespace

RunLog simulate_full_body(const Config& config, const RobotDescription& robot,
                          const std::filesystem::path& urdf, const Observer& observer) {
  return FullBodyLoop(config, robot, urdf).run(observer);
}

}  // namespace saltus::push_recovery
