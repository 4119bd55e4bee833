// A robot in MJCF, the model format of MuJoCo. Does not need MuJoCo.
#pragma once

#include <string>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus::robots::mujoco_engine {

/// The robot above the ground. Names are numbers: body i of the robot and the joint to its parent
/// are both named "i".
std::string to_mjcf(const FloatingRobot& robot, const Plant::Options& options);

/// The same model for other programs, with the names of the URDF. It also has the friction of the
/// drives, one motor per joint with its largest torque, in the order of FloatingRobot::bodies, the
/// sites "imu", "left_sole" and "right_sole", the sensors "gyroscope", "accelerometer" and
/// "orientation" of the base, and `start` as the key frame "start".
std::string to_mjcf(const FloatingRobot& robot, const Plant::Options& options,
                    const WholeBodyState& start);

}  // namespace saltus::robots::mujoco_engine
