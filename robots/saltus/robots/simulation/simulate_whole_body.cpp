// Whole-body simulation: a BalanceController drives a SimulatedRobot.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "saltus/robots/simulation/run_recorder.hpp"
#include "saltus/robots/simulation/simulate.hpp"
#include "saltus/robots/simulation/simulated_robot.hpp"
#include "saltus/robots/walking/balance_controller.hpp"
#include "saltus/robots/walking/cpu_time.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "saltus/robots/whole_body/ground.hpp"
#include "saltus/robots/whole_body/sample_period.hpp"
#include "saltus/robots/whole_body/soft_ground.hpp"

namespace saltus::robots::walking {
namespace {

// The body, with capsules if limbs must not pass through each other or if the description contains
// capsules.
FloatingRobot make_body(const UrdfModel& model, const RobotDescription& description,
                        bool self_collision) {
  FloatingRobot robot = floating_robot(model, description);
  if (self_collision || !description.capsules.empty()) add_capsules(robot, model, description);
  return robot;
}

// The ground beside the stance foot of this side.
DartOptions engine_options(const BipedSettings& settings, Side stance) {
  DartOptions options = settings.plant.engine;
  if (stance == Side::left) options.ground.edge = -options.ground.edge;
  options.self_collision = settings.control.self_collision;
  return options;
}

// The controllers know the speed at which the torque of a motor vanishes.
DriveFactors model_drives(const BipedSettings& settings) {
  DriveFactors factors = settings.robot.drives;
  factors.torque_speed_line = settings.plant.drives.torque_speed_line;
  return factors;
}

// Throws if a foot initially stands beyond the edge of the ground or is inside the ground there.
void expect_room(const BalanceController& controller, const RobotDescription& robot,
                 const Scene& scene, const Plant::Options& engine) {
  constexpr double slack = 1e-3;  // m
  if (engine.ground.is_level()) return;
  const std::vector<GroundBox> boxes = ground_boxes(engine);
  const BalancePlanner::Estimate estimate = controller.centroidal_estimate();
  for (const Side side : {Side::left, Side::right}) {
    const bool standing = side == scene.side || scene.two_feet;
    const Mat<double, 4, 3> corners = foot_corners_3d(estimate.sole(side), robot.foot(side));
    for (int i = 0; i < 4; ++i) {
      const double beyond = engine.ground.ahead ? corners(i, 0) - std::abs(engine.ground.edge)
                                                : corners(i, 1) / engine.ground.edge - 1.0;
      if (beyond <= 0.0) continue;
      const double height = height_at(boxes, corners(i, 0), corners(i, 1));
      const std::string sole = fmt::format("the {} sole (corner at {:.3f}, {:.3f}, {:.3f} m)",
                                           side == Side::left ? "left" : "right", corners(i, 0),
                                           corners(i, 1), corners(i, 2));
      if (standing)
        throw InputError(
            engine.ground.ahead
                ? fmt::format("simulator.ground_*: {} stands beyond the edge at x = {} m, where "
                              "the ground is not level; increase simulator.ground_edge_m",
                              sole, std::abs(engine.ground.edge))
                : fmt::format("simulator.ground_*: {} stands beyond the edge at y = {} m, where "
                              "the ground is not level; use a posture with narrower feet",
                              sole, engine.ground.edge));
      if (corners(i, 2) <= height - slack)
        throw InputError(
            fmt::format("simulator.ground_step_m, ground_slope_* and ground_roughness_m: {} is "
                        "inside the ground, whose height there is {:.3f} m; lower the ground",
                        sole, height));
    }
  }
}

// Both sides of the closed loop: the controller, which runs on the readings of the robot, and the
// robot, which advances by the steps of its engine.
class WholeBodyRun final : LoopController, LoopPlant {
 public:
  WholeBodyRun(const BipedProblem& problem, const RobotDescription& robot, const Observer& observer,
               const UrdfModel& model)
      : settings_(problem.settings()),
        described_(make_body(model, robot, settings_.control.self_collision)),
        body_(with_drives_scaled(described_, settings_.plant.drives)),
        nominal_(with_drives_scaled(
            with_com_shifted(with_masses_scaled(described_, 1.0 + settings_.robot.mass_error),
                             settings_.robot.com_error),
            model_drives(settings_))),
        start_(standing_state(body_, model, robot, problem.posture(robot))),
        scene_(initial_scene(problem, robot)),
        controller_(make_balance_controller(problem, robot, nominal_, make_dart_dynamics(nominal_),
                                            scene_, settings_.plant.engine.step)),
        recorder_(problem, robot, controller_.planner(), observer),
        robot_(make_engine(body_, settings_, scene_.side), body_, settings_.plant,
               settings_.control.period),
        torques_(1, body_.joints()),
        estimates_(settings_.plant.sensors == PlantSettings::Sensors::measured) {
    if (settings_.control.self_collision) expect_apart(body_, start_, problem.posture(robot).name);
    if (estimates_ || !settings_.plant.noise.is_zero() || settings_.robot.mass_error != 0.0 ||
        !settings_.robot.com_error.isZero(0.0))
      true_model_ = make_dart_dynamics(body_);
    const std::vector<Push> pushes = problem.pushes();
    if (!pushes.empty()) pushed_ = frame_of_push(pushes.front(), body_, model);  // the same for all
    robot_.reset(start_);
    controller_.start(start_, robot_.read());
    expect_room(controller_, robot, scene_, engine_options(settings_, scene_.side));
  }

  RunLog run() {
    run_until_over(*this, *this, recorder_);
    RunLog log = recorder_.finish(controller_.applied(), truth_);
    log.floating = described_;
    const DartOptions engine = engine_options(settings_, scene_.side);
    log.ground_friction = std::max(engine.friction, engine.ground.friction);
    log.plant_ground = engine.ground;
    log.pushed = pushed_;
    if (const CorrectedModel* corrected = controller_.corrected_model())
      log.mass_estimate = {corrected->mass(), corrected->com_shift()};
    const BalanceController::Statistics& statistics = controller_.statistics();
    log.control_calls = statistics.calls;
    log.control_failures = statistics.failures;
    log.control_cuts = statistics.cuts;
    log.control_solves = statistics.solves;
    log.control_seconds = statistics.control_seconds;
    log.plan_seconds = statistics.plan_seconds;
    return log;
  }

 private:
  double period() const override { return robot_.period(); }
  const HeldInput& tick(double t, const VectorRef&) override {
    controller_.update(robot_.read());
    note_update();
    torques_.clear();
    HeldInput::Piece& piece = torques_.add();
    piece.start = t;
    piece.length = period();
    piece.size = inputs();
    piece.values = controller_.commands().torques;
    return torques_;
  }

  std::optional<LoopLog::Tick> last_tick() override { return recorder_.take_tick(); }
  double time() const override { return robot_.read().time; }
  VectorXd state() const override { return truth_.gamma; }
  int inputs() const override { return body_.joints(); }
  std::string name() const override { return robot_.name(); }
  bool take_pulses(std::span<const Pulse> pushes) override {
    pushes_.assign(pushes.begin(), pushes.end());
    robot_.push_by(pushes, pushed_);
    return true;
  }
  bool advance(const VectorRef&, double) override {
    robot_.write(controller_.commands());
    const bool has_sample = controller_.last().has_controlled;
    if (has_sample) begin_sample();
    std::string failure;
    {
      CpuTime watch(recorder_.log().plant_seconds);
      failure = robot_.wait();
    }
    for (const Side side : {Side::left, Side::right})
      felt(side) += robot_.engine().contact(side).wrench;
    ++felt_steps_;
    if (has_sample) end_sample();
    recorder_.note_step(failure, truth_);
    return true;
  }

  Vec<double, 6>& felt(Side side) { return felt_[side == Side::left ? 0 : 1]; }
  // Without model errors, the model of the controllers is the true one.
  const DynamicsModel& true_model() const {
    return true_model_ != nullptr ? *true_model_ : controller_.model();
  }

  void note_update() {
    const BalanceController::Update& update = controller_.last();
    if (update.has_controlled) {
      if (true_model_ != nullptr) true_model_->update(robot_.engine().state());
      const DynamicsModel& model = true_model();
      truth_.time = update.time;
      truth_.gamma << model.com(), model.com_velocity(), model.angular_momentum();
      for (const Side side : {Side::left, Side::right})
        truth_.sole(side) = model.sole(side).pose.translation();
    }
    if (update.has_planned)
      recorder_.note_tick(update.time, update.step, update.has_landed,
                          controller_.statistics().step_seconds, truth_);
    else if (update.has_landed)
      recorder_.note_landing(update.time, truth_);
    if (update.has_lost) recorder_.note_loss(update.time);
  }

  // The sample holds until the next call of the whole-body controller.
  void begin_sample() {
    const double t = controller_.last().time;
    const double end =
        static_cast<double>(std::lround(t / robot_.period()) +
                            std::lround(settings_.control.period / robot_.period())) *
        robot_.period();
    recorder_.note_sample(t, controller_.applied(), mean_force(pushes_, t, end), truth_);
    RunLog::BodySample b;
    b.planned = controller_.tasks().wrenches;
    b.state = robot_.engine().state();
    b.left_sole = true_model().sole(Side::left).pose;
    b.right_sole = true_model().sole(Side::right).pose;
    const Side stance = other(controller_.swing_side());
    if (estimates_)
      b.estimate = {controller_.estimate().state, controller_.centroidal_estimate().gamma,
                    controller_.model().sole(stance).pose.translation(), stance};
    recorder_.log().body.push_back(std::move(b));
  }

  // Records the mean force since the last sample, including its first step. An engine may have far
  // higher forces in a single step.
  void end_sample() {
    RunLog::BodySample& b = recorder_.log().body.back();
    b.torques = robot_.motor_torques();
    b.left = felt(Side::left) / static_cast<double>(felt_steps_);
    b.right = felt(Side::right) / static_cast<double>(felt_steps_);
    felt_ = {Vec<double, 6>::Zero(), Vec<double, 6>::Zero()};
    felt_steps_ = 0;
  }

  const BipedSettings& settings_;
  // As described, as simulated, and as the controllers assume it.
  FloatingRobot described_, body_, nominal_;
  WholeBodyState start_;
  Scene scene_;
  BalanceController controller_;
  RunRecorder recorder_;
  SimulatedRobot robot_;
  FloatingRobot::Frame pushed_;
  std::vector<Pulse> pushes_;
  HeldInput torques_;
  bool estimates_;
  std::unique_ptr<DynamicsModel> true_model_;
  TrueState truth_;
  std::array<Vec<double, 6>, 2> felt_{Vec<double, 6>::Zero(), Vec<double, 6>::Zero()};
  int felt_steps_ = 0;
};

}  // namespace

std::unique_ptr<Plant> make_engine(const FloatingRobot& body, const BipedSettings& settings,
                                   Side stance) {
  const DartOptions options = engine_options(settings, stance);
  std::unique_ptr<Plant> engine = settings.plant.choice == PlantSettings::Choice::mujoco
                                      ? make_mujoco_plant(body, options)
                                      : make_dart_plant(body, options);
  return options.ground.sink > 0.0 ? make_soft_ground(std::move(engine), body, options)
                                   : std::move(engine);
}

FloatingRobot::Frame frame_of_push(const Push& push, const FloatingRobot& body,
                                   const UrdfModel& model) {
  FloatingRobot::Frame frame = pushed_frame(body, model, push.link);
  frame.pose.translate(push.point);
  return frame;
}

FloatingRobot::Frame pushed_frame(const FloatingRobot& robot, const UrdfModel& model,
                                  const std::string& link) {
  try {
    return link_frame(robot, model, link);
  } catch (const InputError& error) {
    throw InputError(fmt::format("push.link: {}", error.what()));
  }
}

RunLog simulate_whole_body(const BipedProblem& problem, const RobotDescription& robot,
                           const Observer& observer) {
  const UrdfModel model = UrdfModel::read(urdf_of_body(problem.settings().robot));
  return WholeBodyRun(problem, robot, observer, model).run();
}

}  // namespace saltus::robots::walking
