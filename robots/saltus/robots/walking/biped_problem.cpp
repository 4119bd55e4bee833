#include "saltus/robots/walking/biped_problem.hpp"

#include <fmt/format.h>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/robot_choice.hpp"

namespace saltus::walking {
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

}  // namespace

const StandingPosture& BipedProblem::posture(const RobotDescription& robot) const {
  return posture_on(settings().scene.stance, robot);
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

}  // namespace saltus::walking
