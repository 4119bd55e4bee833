#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus::robots {

std::unique_ptr<WholeBodyController> make_whole_body_controller(
    const FloatingRobot& robot, const ContactCone::Options& left, const ContactCone::Options& right,
    const WholeBodyController::Options& control) {
  if (control.choice == WholeBodyController::Method::momentum)
    return make_momentum_controller(robot, left, right, control.momentum);
  WholeBodyController::Gains gains = control.gains;
  gains.speed_limits = control.joint_speed_limits;
  gains.clearance = control.self_collision;
  return make_inverse_dynamics_controller(robot, left, right, control.inverse_dynamics, gains);
}

}  // namespace saltus::robots
