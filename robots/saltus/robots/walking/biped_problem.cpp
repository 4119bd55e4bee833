#include "saltus/robots/walking/biped_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/balance_controller.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "saltus/robots/whole_body/sample_period.hpp"

namespace saltus::robots::walking {
namespace {

// Checks that one foot can carry the robot, and that two feet can carry their least forces.
void check_normal_forces(const ContactSettings& contact, const RobotDescription& robot) {
  const double weight = robot.mass * standard_gravity;
  if (contact.normal_force_max < weight)
    throw InputError(
        fmt::format("contact.fz_max ({} N) is less than the robot's weight, {:.0f} N, which one "
                    "foot carries; raise it",
                    contact.normal_force_max, weight));
  if (contact.normal_force_min > 0.5 * weight)
    throw InputError(fmt::format(
        "contact.fz_min ({} N) is more than half of the robot's weight, {:.0f} N: two feet cannot "
        "both carry it; lower it",
        contact.normal_force_min, weight));
}

// A foot has landed when it carries this fraction of the weight, 20 N for iCub.
constexpr double landed_share = 20.0 / (mass_of_the_defaults * standard_gravity);

// Settings of the whole-body controller, with the delay of the measured velocities. `step` is the
// time between two readings, s.
WholeBodyController::Options control_of(const BipedSettings& settings, double step) {
  WholeBodyController::Options control = settings.control;
  if (settings.plant.sensors == PlantSettings::Sensors::measured) {
    const SensorOptions::Encoder& encoder = settings.plant.sensor.encoder;
    const double period = sample_period(encoder.rate, step);
    const double delay = step * std::round(encoder.delay / step);
    // The difference of two readings lags by half a period at least and is held until the next
    // reading.
    control.gains.velocity_age = delay +
                                 std::max(settings.plant.estimation.velocity_lag, 0.5 * period) +
                                 0.5 * (period - step);
  }
  return control;
}

}  // namespace

const StandingPosture& BipedProblem::posture(const RobotDescription& robot) const {
  return posture_at_start(settings().scene, robot);
}

std::vector<Push> BipedProblem::pushes() const {
  return all_pushes(settings().push, settings().more_pushes);
}

Schedule BipedProblem::contacts(const Scene& scene) const {
  return first_contacts(settings(), scene);
}

std::optional<BipedProblem::StepBounds> BipedProblem::step_bounds(const RobotDescription&) const {
  return std::nullopt;
}

std::unique_ptr<StepPlanner> BipedProblem::make_step_planner(const RobotDescription&,
                                                             const Scene&) const {
  return std::make_unique<StepPlanner>();
}

std::unique_ptr<UnmetExplanations> BipedProblem::unmet_explanations(
    const RobotDescription& /*robot*/) const {
  return std::make_unique<UnmetExplanations>();
}

std::string BipedProblem::lost(double t, const Vec<double, 9>& gamma, const Scene& scene) const {
  return has_fallen(gamma, scene.stance.position, scene.com_height) ? fall_sentence(pushes(), t)
                                                                    : std::string();
}

Scene initial_scene(const BipedProblem& problem, const RobotDescription& robot) {
  Scene scene = scene_of(problem.posture(robot), robot);
  scene.target = problem.settings().scene.target;
  return scene;
}

RobotDescription robot_of(const BipedSettings& settings) {
  RobotDescription robot = robot_of(settings.robot, settings.plant.is_whole_body());
  check_normal_forces(settings.contact, robot);
  return robot;
}

std::unique_ptr<Planner> make_planner(const BipedProblem& problem, const RobotDescription& robot,
                                      const Scene& scene) {
  const BipedSettings& settings = problem.settings();
  const RobotDescription nominal = nominal_robot(settings.robot, robot);
  if (settings.controller == BipedSettings::Controller::capture_point)
    return make_capture_point_controller(settings.baseline, settings.planner, settings.contact,
                                         nominal, scene, problem.contacts(scene));
  return problem.make_planner(nominal, scene);
}

std::unique_ptr<StepPlanner> make_step_planner(const BipedProblem& problem,
                                               const RobotDescription& robot, const Scene& scene) {
  return problem.make_step_planner(nominal_robot(problem.settings().robot, robot), scene);
}

BalanceController make_balance_controller(const BipedProblem& problem,
                                          const RobotDescription& robot, const FloatingRobot& body,
                                          std::unique_ptr<DynamicsModel> model, const Scene& scene,
                                          double period) {
  const BipedSettings& settings = problem.settings();
  BalanceController::Parts parts;
  if (settings.plant.sensors == PlantSettings::Sensors::ideal)
    parts.estimator = make_ideal_estimator();
  else
    parts.estimator = make_sensor_estimator(body, scene.side, settings.plant.sensor,
                                            settings.plant.estimation, period);
  if (settings.mass_estimate.is_estimated)
    parts.corrected =
        std::make_unique<CorrectedModel>(std::move(model), body, settings.mass_estimate);
  else
    parts.model = std::move(model);
  parts.whole_body = make_whole_body_controller(
      body, cone_options(settings.contact, robot.left_foot),
      cone_options(settings.contact, robot.right_foot), control_of(settings, period));
  parts.drives =
      std::make_unique<DriveController>(body, settings.drive_control, settings.control.period);
  parts.steps = make_step_planner(problem, robot, scene);
  parts.wrenches = make_planner(problem, robot, scene);
  FootSupportOptions support = settings.foot_support;
  support.damping = settings.control.choice == WholeBodyController::Method::momentum
                        ? settings.control.momentum.stance_damping
                        : settings.control.gains.stance_damping;
  ContactEstimator::Options contact;
  contact.is_estimated = support.is_estimated;
  contact.force = landed_share * robot.mass * standard_gravity;
  return {std::move(parts),
          {period, settings.control.period, settings.planner.step, contact, settings.stance_foot,
           support, settings.swing_foot, scene, problem.contacts(scene)}};
}

}  // namespace saltus::robots::walking
