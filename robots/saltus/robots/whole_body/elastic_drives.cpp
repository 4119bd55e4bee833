#include "saltus/robots/whole_body/elastic_drives.hpp"

#include <fmt/format.h>

#include <cmath>

#include "saltus/core/error.hpp"

namespace saltus::robots {

ElasticDrives::ElasticDrives(const FloatingRobot& robot, double step)
    : step_(step),
      speeds_(VectorXd::Zero(robot.joints())),
      torques_(speeds_),
      inertias_(robot.joints()) {
  for (Eigen::Index i = 0; i < inertias_.size(); ++i) {
    const FloatingRobot::Body& body = robot.bodies[static_cast<std::size_t>(i) + 1];
    const JointDrive& drive = body.drive;
    const auto refuse = [&body](const std::string& reason) {
      throw DefinitionError(fmt::format("joint \"{}\" {}", body.joint, reason));
    };
    if (!(drive.stiffness > 0.0))
      refuse(fmt::format("has a drive of stiffness {}; set a positive one", drive.stiffness));
    if (!(drive.backlash >= 0.0) || !std::isfinite(drive.backlash))
      refuse(fmt::format("has a backlash of {}; set it to 0 or more", drive.backlash));
    inertias_[i] = drive.rotor_inertia;
    if (drive.stiffness == infinity) {
      if (drive.backlash > 0.0) refuse("has backlash but no spring; set its stiffness");
      continue;
    }
    if (!(drive.rotor_inertia > 0.0))
      refuse("has a spring but no rotor inertia; set its rotor_inertia");
    springs_.push_back({i, drive.rotor_inertia, drive.stiffness, 0.5 * drive.backlash});
  }
}

const VectorXd& ElasticDrives::rotor_speeds(const VectorXd& dq) {
  speeds_ = dq;
  if (is_loaded_)
    for (const Spring& spring : springs_) speeds_[spring.joint] = spring.speed;
  return speeds_;
}

const VectorXd& ElasticDrives::begin_step(const VectorXd& q, const VectorXd& dq,
                                          const VectorXd& torques) {
  torques_ = torques;
  for (Spring& spring : springs_) {
    const Eigen::Index i = spring.joint;
    const double motor = torques[i];
    if (!is_loaded_) {
      const double play = motor == 0.0 ? 0.0 : std::copysign(spring.half_play, motor);
      spring.angle = q[i] + play + motor / spring.stiffness;
      spring.speed = dq[i];
    }
    spring.motor = motor;
    spring.joint_speed = dq[i];
    torques_[i] = inertias_[i] = 0.0;
    const double twist = spring.angle - q[i];
    if (std::abs(twist) <= spring.half_play) continue;
    const double torque = spring.stiffness * (twist - std::copysign(spring.half_play, twist));
    const double moving =
        1.0 / (1.0 / (step_ * step_ * spring.stiffness) + 1.0 / spring.rotor_inertia);
    const double speed = spring.speed + step_ * (motor - torque) / spring.rotor_inertia;
    inertias_[i] = moving;
    torques_[i] = torque + moving / step_ * (speed - dq[i]);
  }
  is_loaded_ = true;
  return torques_;
}

void ElasticDrives::end_step(const VectorXd& dq) {
  for (Spring& spring : springs_) {
    const Eigen::Index i = spring.joint;
    const double torque = torques_[i] - inertias_[i] * (dq[i] - spring.joint_speed) / step_;
    spring.speed += step_ * (spring.motor - torque) / spring.rotor_inertia;
    spring.angle += step_ * spring.speed;
  }
}

}  // namespace saltus::robots
