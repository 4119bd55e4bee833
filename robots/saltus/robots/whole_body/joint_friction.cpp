#include "saltus/robots/whole_body/joint_friction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"

namespace saltus::robots {
namespace {

// Natural frequency (rad/s) and damping ratio of the rotor on its bristles. An explicit step of 1
// ms is stable, and a joint that is held by 2 Nm moves by less than a milliradian.
constexpr double bristle_frequency = 150.0, bristle_damping = 0.7;

}  // namespace

JointFriction::JointFriction(const FloatingRobot& robot, double step)
    : joints_(static_cast<std::size_t>(robot.joints())),
      step_(step),
      bent_(VectorXd::Zero(robot.joints())),
      torques_(bent_) {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const FloatingRobot::Body& body = robot.bodies[i + 1];
    const JointDrive& drive = body.drive;
    const auto expect = [&](bool good, const char* what, double value) {
      if (!good || !std::isfinite(value))
        throw DefinitionError(
            fmt::format("joint \"{}\": its {} must not be {}", body.joint, what, value));
    };
    expect(drive.viscous_friction >= 0.0, "viscous friction", drive.viscous_friction);
    expect(drive.dry_friction >= 0.0, "dry friction", drive.dry_friction);
    expect(drive.breakaway >= 1.0, "breakaway", drive.breakaway);
    expect(drive.stribeck_speed > 0.0, "Stribeck speed", drive.stribeck_speed);
    expect(drive.rotor_inertia >= 0.0, "rotor inertia", drive.rotor_inertia);
    if (drive.dry_friction > 0.0 && drive.rotor_inertia == 0.0)
      throw DefinitionError(fmt::format(
          "joint \"{}\" has dry friction but no rotor inertia; set its rotor_inertia", body.joint));
    Joint& joint = joints_[i];
    joint.viscous = drive.viscous_friction;
    joint.dry = drive.dry_friction;
    joint.breakaway = drive.breakaway;
    joint.stribeck_speed = drive.stribeck_speed;
    joint.stiffness = bristle_frequency * bristle_frequency * drive.rotor_inertia;
    joint.damping = 2.0 * bristle_damping * bristle_frequency * drive.rotor_inertia;
    is_zero_ = is_zero_ && joint.viscous == 0.0 && joint.dry == 0.0;
  }
}

const VectorXd& JointFriction::step(const VectorXd& dq) {
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    const Joint& joint = joints_[k];
    const auto i = static_cast<Eigen::Index>(k);
    torques_[i] = joint.viscous * dq[i];
    if (joint.dry == 0.0) continue;
    const double ratio = dq[i] / joint.stribeck_speed;
    const double largest = joint.dry * (1.0 + (joint.breakaway - 1.0) * std::exp(-ratio * ratio));
    const double most = largest / joint.stiffness, before = bent_[i];
    bent_[i] = std::clamp(before + step_ * dq[i], -most, most);
    const double rate = (bent_[i] - before) / step_;
    torques_[i] += std::clamp(joint.stiffness * bent_[i] + joint.damping * rate, -largest, largest);
  }
  return torques_;
}

}  // namespace saltus::robots
