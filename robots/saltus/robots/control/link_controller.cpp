#include "saltus/robots/control/link_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus::robots::control {

std::vector<std::string> names_of(const std::vector<LinkJoint>& joints) {
  std::vector<std::string> names;
  names.reserve(joints.size());
  for (const LinkJoint& joint : joints) names.push_back(joint.name);
  return names;
}

std::vector<LinkJoint> joints_of(const FloatingRobot& body, const VectorXd& posture) {
  if (posture.size() != body.joints())
    throw DefinitionError(fmt::format("robot control: the posture has {} joints, the robot {}",
                                      posture.size(), body.joints()));
  std::vector<LinkJoint> joints;
  for (int i = 0; i < body.joints(); ++i) {
    const FloatingRobot::Body& b = body.bodies[static_cast<std::size_t>(i) + 1];
    if (!(b.effort < infinity))
      throw InputError(fmt::format(
          "the joint {} has no largest torque; a robot in another process needs one in its URDF",
          b.joint));
    joints.push_back({b.joint, b.effort, b.velocity, b.position, posture[i]});
  }
  return joints;
}

BalanceLink::BalanceLink(walking::BalanceController& controller, WholeBodyState posture,
                         double largest_tilt)
    : controller_(controller), posture_(std::move(posture)), largest_tilt_(largest_tilt) {
  readings_.q = VectorXd::Zero(posture_.q.size());
}

void BalanceLink::read(double time, const SensorMessage& r) {
  readings_.time = time;
  readings_.q = r.q;
  readings_.has_new_positions = true;
  readings_.angular_velocity = r.angular_velocity;
  readings_.specific_force = r.specific_force;
  readings_.left = r.left;
  readings_.right = r.right;
}

void BalanceLink::start(const SensorMessage& readings) {
  read(0.0, readings);
  controller_.start(posture_, readings_);
}

const Robot::Commands& BalanceLink::update(double time, const SensorMessage& readings) {
  read(time, readings);
  return controller_.update(readings_);
}

// Prepares the next plan without readings, after the command of a plan was sent.
void BalanceLink::prepare() {
  if (!controller_.last().has_planned) return;
  controller_.prepare(readings_.time + controller_.planner().planner().controller().period());
}

std::string BalanceLink::fault() const {
  const Eigen::Isometry3d& base = controller_.estimate().state.base;
  const double tilt =
      std::acos(std::clamp(base.linear().col(2).dot(posture_.base.linear().col(2)), -1.0, 1.0));
  if (tilt < largest_tilt_) return {};
  return fmt::format(
      "the robot has fallen: its base is inclined by {:.2f} rad; put it into its "
      "first posture and start again",
      tilt);
}

}  // namespace saltus::robots::control
