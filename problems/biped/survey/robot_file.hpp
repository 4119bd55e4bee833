// Generates the configuration file of a robot from its URDF alone.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problems/biped/survey/limbs.hpp"
#include "saltus/robots/model/robot_description.hpp"

namespace saltus::survey {

struct SurveyedRobot {
  robots::RobotDescription description;
  Limbs limbs;
  std::vector<std::string> notes;  ///< assumptions, one sentence each
};

/// Finds feet, joints, sides and three postures: on the left foot, on the right foot and on both,
/// with bent knees and the CoM above the middle of the support. Throws InputError if the URDF lacks
/// data or the joints do not reach a posture.
SurveyedRobot survey_robot(const robots::UrdfModel& model);

/// Text of the configuration file. read_robot_description() reads it back.
std::string to_yaml(const SurveyedRobot& robot, const robots::UrdfModel& model);

}  // namespace saltus::survey
