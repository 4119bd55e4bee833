#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/ocp/window.hpp"
#include "saltus/robots/dart/dart_dynamics.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/levelled.hpp"
#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "saltus/robots/walking/biped_problem.hpp"
#include "saltus/robots/walking/cpu_time.hpp"
#include "saltus/robots/walking/legged_plant.hpp"
#include "saltus/robots/whole_body/collision_shapes.hpp"
#include "saltus/robots/whole_body/estimated_plant.hpp"
#include "saltus/robots/whole_body/swing_foot.hpp"

namespace saltus::walking {
namespace {

// A foot has landed when the ground carries this share of the weight: 20 N of iCub's.
constexpr double landed_share = 20.0 / (mass_of_the_defaults * standard_gravity);

// With capsules where limbs may not pass through each other, and where they cost nothing to have.
FloatingRobot make_body(const UrdfModel& model, const RobotDescription& description,
                        bool self_collision) {
  FloatingRobot robot = floating_robot(model, description);
  if (self_collision || !description.capsules.empty()) add_capsules(robot, model, description);
  return robot;
}

std::unique_ptr<Plant> make_plant(const FloatingRobot& robot, const PlantSettings& settings,
                                  Side stance, bool self_collision) {
  DartOptions options;
  options.step = settings.step;
  options.friction = settings.friction;
  options.ground_step = settings.ground_step;
  options.ground_edge = (stance == Side::left ? -1.0 : 1.0) * settings.ground_edge;
  options.joint_friction = settings.joint_friction;
  options.collision = settings.collision;
  options.lcp = settings.lcp;
  options.cone = settings.cone;
  options.self_collision = self_collision;
  std::unique_ptr<Plant> plant = settings.choice == PlantChoice::mujoco
                                     ? make_mujoco_plant(robot, options)
                                     : make_dart_plant(robot, options);
  if (settings.motors.is_ideal()) return plant;
  return with_motors(std::move(plant), settings.motors, settings.step);
}

// What stands between the engine and the controllers.
struct Senses {
  std::unique_ptr<Plant> plant;
  EstimatedPlant* estimated = nullptr;  // the same, if it estimates
};
Senses make_senses(std::unique_ptr<Plant> engine, const FloatingRobot& nominal, Side stance,
                   const PlantSettings& settings) {
  auto plant =
      std::make_unique<MeasuredPlant>(std::move(engine), settings.noise, settings.delay_ticks);
  if (settings.sensors == SensorChoice::ideal) return {std::move(plant)};
  auto estimated = std::make_unique<EstimatedPlant>(
      std::move(plant), nominal, stance, settings.sensor, settings.estimation, settings.step);
  EstimatedPlant* const view = estimated.get();
  return {std::move(estimated), view};
}

// A controller that knows how late the velocities are that it sees.
WholeBodyControl control_by(WholeBodyControl control, const PlantSettings& settings) {
  if (settings.sensors == SensorChoice::measured) {
    const double step = settings.step;
    const double period = sample_period(settings.sensor.encoder.rate, step);
    const double delay = step * std::round(settings.sensor.encoder.delay / step);
    // Differences of two readings are half a period old at least, and held until the next.
    control.gains.velocity_age =
        delay + std::max(settings.estimation.velocity_lag, 0.5 * period) + 0.5 * (period - step);
  }
  return control;
}

Vec<double, 9> gamma(const DynamicsModel& model) {
  Vec<double, 9> g;
  g << model.com(), model.com_velocity(), model.angular_momentum();
  return g;
}

// Planners take soles to be level, whole-body controllers as they are: components along the axes of
// the first to components along those of the second.
Mat<double, 3, 3> from_level(const SoleFrame& sole) {
  return sole.rotation.transpose() * levelled(sole).rotation;
}
// Force and torque of this foot.
void turn(const Mat<double, 3, 3>& rotation, Side foot, Vec<double, 12>& wrenches) {
  for (const int part : {0, 3}) {
    auto vector = wrenches.segment<3>((foot == Side::left ? 0 : 6) + part);
    vector = (rotation * vector).eval();
  }
}

// Counts steps of the engine: times are multiples of its step, periods whole numbers of them.
class WholeBodyLeggedPlant final : public LeggedPlant {
 public:
  WholeBodyLeggedPlant(const PlantStart& start, const WholeBodyOptions& options,
                       const PlantSettings& settings, const UrdfModel& model)
      : step_(settings.step),
        friction_(settings.friction),
        landed_force_(landed_share * start.robot.mass * standard_gravity),
        per_control_(std::lround(options.control.period / settings.step)),
        per_plan_(std::lround(start.period / settings.step)),
        swing_side_(other(start.scene.side)),
        body_(make_body(model, start.robot, options.control.self_collision)),
        nominal_(with_masses_scaled(body_, 1.0 + start.mass_error)),
        pushes_(start.pushes),
        dynamics_(make_dart_dynamics(nominal_)),
        engine_(make_plant(body_, settings, start.scene.side, options.control.self_collision)),
        truth_of_plant_(*engine_),
        senses_(make_senses(std::move(engine_), nominal_, start.scene.side, settings)),
        plant_(senses_.plant.get()),
        controller_(make_whole_body_controller(
            nominal_, cone_options(options.contact, start.robot.left_foot),
            cone_options(options.contact, start.robot.right_foot),
            control_by(options.control, settings))) {
    for (const Push& push : pushes_) {
      pushed_.push_back(pushed_frame(body_, model, push.link));
      pushed_.back().pose.translate(push.point);
    }
    const WholeBodyState state = standing_state(body_, model, start.robot, start.posture);
    if (options.control.self_collision) expect_apart(body_, state, start.posture.name);
    estimates_ = settings.sensors == SensorChoice::measured;
    if (estimates_ || !settings.noise.is_zero() || start.mass_error != 0.0)
      truth_ = make_dart_dynamics(body_);
    plant_->reset(state);
    controller_->stand(state);
    update_dynamics();
    expect_room(start, settings);
    swing_.hold(dynamics_->sole(swing_side_).pose);
    stands(swing_side_) = start.scene.two_feet;
    tasks_.posture = state.q;
    applied_ = start.scene.standing_wrenches(nominal_.total_mass, dynamics_->com());
    stands(other(swing_side_)) = true;
  }

  double tick_time(long k) const override { return static_cast<double>(k * per_plan_) * step_; }
  double step_end(double, double) const override { return static_cast<double>(steps_ + 1) * step_; }

  double sample_end(double) const override {
    return static_cast<double>(steps_ + per_control_) * step_;
  }

  bool sense(double t) override {
    if (!is_control_due()) return false;
    update_dynamics();
    sensed_at_ = t;
    return true;
  }
  Vec<double, 9> measured() const override { return gamma(*dynamics_); }
  double nominal_mass() const override { return dynamics_->mass(); }
  SoleFrame sole(Side foot) const override {
    const Eigen::Isometry3d& pose = dynamics_->sole(foot).pose;
    return {pose.translation(), pose.linear()};
  }
  Vec<double, 3> sole_velocity(Side foot) const override {
    return dynamics_->sole(foot).twist.tail<3>();
  }
  const Vec<double, 12>& applied() const override { return applied_; }
  Vec<double, 3> contact_force() const override {
    return levelled(sole(Side::left)).rotation * applied_.segment<3>(0) +
           levelled(sole(Side::right)).rotation * applied_.segment<3>(6);
  }
  bool lands_on_time() const override { return false; }

  void lift_off(double, Side foot) override {
    swing_side_ = foot;
    stands(foot) = false;
    swing_.hold(dynamics_->sole(foot).pose);
    if (senses_.estimated != nullptr) senses_.estimated->pin(other(foot));
  }
  void swing(double t, const SwingTarget& target) override {
    if (!swing_.is_under_way()) swing_.start(t, target.landing);
    swing_.aim(target.landing, target.place);
    earliest_landing_ = target.earliest;
  }
  std::optional<Landing> find_landing(double t) override {
    if (!swing_.is_under_way() || stands(swing_side_)) return std::nullopt;
    const FootContact& contact = plant_->contact(swing_side_);
    if (t < earliest_landing_ || contact.wrench[2] < landed_force_) return std::nullopt;
    stands(swing_side_) = true;
    return Landing{dynamics_->sole(swing_side_).pose.translation(),
                   true_dynamics().sole(swing_side_).pose.translation()};
  }

  void command(double t, const Vec<double, 12>& wrenches) override {
    if (!is_control_due()) return;
    CpuTime watch(control_seconds_);
    tasks_.wrenches = wrenches;
    tasks_.force = Vec<double, 3>(0.0, 0.0, -nominal_.total_mass * standard_gravity);
    tasks_.torque.setZero();
    const Mat<double, 3, 3> into_sole[] = {from_level(sole(Side::left)),
                                           from_level(sole(Side::right))};
    for (const Side side : {Side::left, Side::right}) {
      const int first = side == Side::left ? 0 : 6;
      if (side == swing_side_ && !stands(swing_side_)) tasks_.wrenches.segment<6>(first).setZero();
      const SoleMotion& sole = dynamics_->sole(side);
      turn(into_sole[side == Side::right], side, tasks_.wrenches);
      const Vec<double, 3> f = sole.pose.linear() * tasks_.wrenches.segment<3>(first);
      tasks_.force += f;
      tasks_.torque += sole.pose.linear() * tasks_.wrenches.segment<3>(first + 3) +
                       (sole.pose.translation() - dynamics_->com()).cross(f);
    }
    swing_.advance(t);
    tasks_.swing_acceleration = swing_.acceleration(dynamics_->sole(swing_side_));
    const WholeBodyCommand& command = controller_->control(*dynamics_, plant_->state(), tasks_);
    if (command.status != QpStatus::optimal) ++failures_;
    if (command.torques_cut > 0) ++cuts_;
    solves_.add(command.solve_seconds);
    ++calls_;
    command_ = &command;
    plant_->set_torques(command.torques);
    applied_ = command.wrenches;
    for (const Side side : {Side::left, Side::right})
      turn(into_sole[side == Side::right].transpose(), side, applied_);
  }

  std::string step(double from, double to) override {
    CpuTime watch(plant_seconds_);
    for (std::size_t i = 0; i < pushes_.size(); ++i) {
      const Vec<double, 3> force = mean_push_force(pushes_[i], from, to);
      if (!force.isZero(0.0)) plant_->push(pushed_[i].body, force, pushed_[i].pose.translation());
    }
    before_ = truth_of_plant_.state();
    if (estimates_) estimate_before_ = plant_->state();
    if (was_control_due_) felt_ = {};  // the sample has them
    was_control_due_ = is_control_due();
    plant_->step();
    ++steps_;
    felt_.left += truth_of_plant_.contact(Side::left).wrench;
    felt_.right += truth_of_plant_.contact(Side::right).wrench;
    ++felt_.steps;
    if (truth_of_plant_.state().is_finite()) return {};
    return fmt::format("the plant could not be integrated at {:.3f} s", from);
  }

  double truth_time() const override { return sensed_at_; }
  Vec<double, 9> truth() const override { return gamma(true_dynamics()); }
  Vec<double, 3> true_sole(Side foot) const override {
    return true_dynamics().sole(foot).pose.translation();
  }
  std::optional<BodySample> body_sample() const override {
    if (!was_control_due_) return std::nullopt;
    BodySample b;
    b.planned = tasks_.wrenches;
    b.state = before_;
    b.torques = command_->torques;
    b.left = felt_.left / static_cast<double>(felt_.steps);
    b.right = felt_.right / static_cast<double>(felt_.steps);
    b.left_sole = true_dynamics().sole(Side::left).pose;
    b.right_sole = true_dynamics().sole(Side::right).pose;
    if (estimates_)
      b.estimate = {estimate_before_, measured(),
                    dynamics_->sole(other(swing_side_)).pose.translation(), other(swing_side_)};
    return b;
  }
  void describe(RunLog& log) const override {
    log.plant = plant_->name();
    log.floating = body_;
    log.ground_friction = friction_;
    if (!pushed_.empty()) log.pushed = pushed_.front();
    log.control_calls = calls_;
    log.control_failures = failures_;
    log.control_cuts = cuts_;
    log.control_solves = solves_;
    log.control_seconds = control_seconds_;
    log.plant_seconds = plant_seconds_;
  }

 private:
  // Where the ground's step begins no foot may stand, nor be within it.
  void expect_room(const PlantStart& start, const PlantSettings& settings) const {
    constexpr double slack = 1e-3;  // m
    if (settings.ground_step == 0.0) return;
    const double edge =
        start.scene.side == Side::left ? -settings.ground_edge : settings.ground_edge;
    for (const Side side : {Side::left, Side::right}) {
      const bool standing = side == start.scene.side || start.scene.two_feet;
      const SoleFrame at = sole(side);
      const Mat<double, 4, 3> corners = foot_corners_3d(at, start.robot.foot(side));
      for (int i = 0; i < 4; ++i) {
        const bool is_beyond = corners(i, 1) / edge > 1.0;
        if (!is_beyond || (!standing && corners(i, 2) > settings.ground_step - slack)) continue;
        throw InputError(
            fmt::format("simulator.ground_edge: {} m from the origin the {} sole {} the ground's "
                        "step of {} m (its corner is at y = {:.3f} m); put the edge beyond it",
                        settings.ground_edge, side == Side::left ? "left" : "right",
                        standing ? "stands on" : "is within", settings.ground_step, corners(i, 1)));
      }
    }
  }

  bool is_control_due() const { return steps_ % per_control_ == 0; }
  bool& stands(Side foot) { return foot == Side::left ? tasks_.left_stands : tasks_.right_stands; }
  // The controllers' model at what is measured; the truth, for the log, where that differs.
  void update_dynamics() {
    {
      CpuTime watch(control_seconds_);
      dynamics_->update(plant_->state());
    }
    if (truth_ != nullptr) truth_->update(truth_of_plant_.state());
  }
  const DynamicsModel& true_dynamics() const { return truth_ != nullptr ? *truth_ : *dynamics_; }

  double step_;
  double friction_;      // of the ground
  double landed_force_;  // N
  long per_control_, per_plan_, steps_ = 0;
  Side swing_side_;
  FloatingRobot body_;
  FloatingRobot nominal_;  // by the controllers
  std::vector<Push> pushes_;
  std::vector<FloatingRobot::Frame> pushed_;  // where each acts
  std::unique_ptr<DynamicsModel> dynamics_, truth_;
  std::unique_ptr<Plant> engine_;  // until senses_ have it
  const Plant& truth_of_plant_;
  Senses senses_;
  Plant* plant_;  // as the controllers see it
  bool estimates_ = false;
  std::unique_ptr<WholeBodyController> controller_;
  SwingFoot swing_;
  double earliest_landing_ = infinity, sensed_at_ = 0.0;
  WholeBodyTasks tasks_;
  WholeBodyState before_, estimate_before_;  // of the last step
  bool was_control_due_ = false;
  // Wrenches of the engine's steps since the last sample: it may have far higher ones for a single
  // step.
  struct {
    Vec<double, 6> left = Vec<double, 6>::Zero(), right = Vec<double, 6>::Zero();
    int steps = 0;
  } felt_;
  const WholeBodyCommand* command_ = nullptr;
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
  long calls_ = 0, failures_ = 0, cuts_ = 0;
  LatencyHistogram solves_;
  double control_seconds_ = 0.0, plant_seconds_ = 0.0;
};

}  // namespace

FloatingRobot::Frame pushed_frame(const FloatingRobot& robot, const UrdfModel& model,
                                  const std::string& link) {
  try {
    return link_frame(robot, model, link);
  } catch (const InputError& error) {
    throw InputError(fmt::format("push.link: {}", error.what()));
  }
}

std::unique_ptr<LeggedPlant> make_whole_body_legged_plant(const PlantStart& start,
                                                          const WholeBodyOptions& options,
                                                          const PlantSettings& settings) {
  return std::make_unique<WholeBodyLeggedPlant>(start, options, settings,
                                                UrdfModel::read(options.urdf));
}

}  // namespace saltus::walking
