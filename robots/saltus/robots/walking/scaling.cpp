#include <cmath>

#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::robots::walking {
namespace {

// Two decimals are enough for weights.
double rounded(double ratio) { return std::round(100.0 * ratio) / 100.0; }

}  // namespace

RobotScale scale_of(const RobotDescription& robot) {
  constexpr double icub_height = 0.5578762015;  // icub.yaml, m
  return {rounded(robot.mass / mass_of_the_defaults),
          rounded(robot.default_posture().com.z() / icub_height)};
}

void scale(BipedSettings& settings, const RobotScale& scale) {
  const double M = scale.mass, L = scale.length;
  Step& step = settings.step;  // times are kept: a tall robot gains nothing by waiting longer
  step.fixed_place *= L;
  step.lateral_min *= L;
  step.lateral_max *= L;
  step.forward_max *= L;
  ContactSettings& contact = settings.contact;
  contact.normal_force_min *= M;
  contact.normal_force_max *= M;
  contact.torsional_friction *= L;
  WholeBodyController::Weights& body = settings.control.inverse_dynamics;
  body.linear_momentum /= M * M;
  body.angular_momentum /= M * M * L * L;
  body.wrench /= M * M;
  body.posture *= L * L;  // angular accelerations scale with 1 / L
  settings.plant.estimation.standing_force *= M;
  WholeBodyController::MomentumOptions& momentum = settings.control.momentum;
  momentum.linear_momentum /= M * M;
  momentum.angular_momentum /= M * M * L * L;
  momentum.wrench /= M * M;
}

}  // namespace saltus::robots::walking
