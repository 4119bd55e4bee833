#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::walking {

const StandingPosture& BipedProblem::posture(const RobotDescription& robot) const {
  return robot.posture_on(settings().scene.stance);
}

std::vector<Push> BipedProblem::pushes() const { return {settings().push}; }

Schedule BipedProblem::contacts(const Scene& scene) const {
  return scene.two_feet ? two_feet_throughout() : one_foot_then_two();
}

std::unique_ptr<StepPlanner> BipedProblem::make_step_planner(const Scene&) const {
  return std::make_unique<StepPlanner>();
}

std::string BipedProblem::lost(double t, const Vec<double, 9>& gamma, const Scene& scene) const {
  return has_fallen(gamma, scene.com_height) ? fall_sentence(pushes(), t) : std::string();
}

Scene initial_scene(const BipedProblem& problem, const RobotDescription& robot) {
  Scene scene = scene_of(problem.posture(robot), robot);
  scene.target = problem.settings().scene.target;
  return scene;
}

RobotDescription robot_of(const BipedSettings& settings) {
  return robot_of(settings.robot, settings.plant.is_whole_body());
}

}  // namespace saltus::walking
