#include "saltus/robots/whole_body/whole_body_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"

namespace saltus::robots {

DriveController::DriveController(const FloatingRobot& robot, const Options& options, double period)
    : options_(options),
      period_(period),
      position_(VectorXd::Zero(robot.joints())),
      velocity_(position_),
      has_springs_(options.stiffness > 0.0 || options.damping > 0.0) {
  const auto expect = [](bool good, const char* what, double value) {
    if (!good || !std::isfinite(value))
      throw DefinitionError(fmt::format("drive controller: {} must not be {}", what, value));
  };
  expect(options.stiffness >= 0.0, "the stiffness", options.stiffness);
  expect(options.damping >= 0.0, "the damping", options.damping);
  expect(options.follow > 0.0, "the time constant", options.follow);
  expect(period > 0.0, "the period", period);
  commands_.torques = position_;
  if (has_springs_) {
    commands_.positions = commands_.velocities = position_;
    commands_.stiffness.resize(robot.joints());
    commands_.damping.resize(robot.joints());
  }
  for (int i = 0; i < robot.joints(); ++i) {
    const FloatingRobot::Body& body = robot.bodies[i + 1];
    drives_.push_back(body.drive);
    if (!has_springs_) continue;
    if (!std::isfinite(body.effort))
      throw DefinitionError(fmt::format(
          "drive controller: joint \"{}\" has no effort limit, which its stiffness needs; set one",
          body.joint));
    commands_.stiffness[i] = options.stiffness * body.effort;
    commands_.damping[i] = options.damping * body.effort;
  }
}

void DriveController::start(const VectorXd& q) {
  position_ = q;
  velocity_.setZero();
  commands_.torques = VectorXd::Zero(q.size());
  if (!has_springs_) return;
  commands_.positions = q;
  commands_.velocities.setZero();
}

const Robot::Commands& DriveController::update(const WholeBodyController::Command& command,
                                               const WholeBodyState& state) {
  const double followed = std::min(1.0, period_ / options_.follow);
  for (Eigen::Index i = 0; i < position_.size(); ++i) {
    const double acceleration = command.joint_acceleration[i];
    position_[i] += followed * (state.q[i] - position_[i]);
    velocity_[i] += followed * (state.dq[i] - velocity_[i]);
    // Mean over the period in which the command acts.
    const double speed = velocity_[i] + 0.5 * period_ * acceleration;
    commands_.torques[i] =
        command.torques[i] + drives_[static_cast<std::size_t>(i)].friction(speed);
    if (has_springs_) {
      commands_.positions[i] = position_[i];
      commands_.velocities[i] = speed;
    }
    position_[i] += period_ * speed;
    velocity_[i] += period_ * acceleration;
  }
  return commands_;
}

}  // namespace saltus::robots
