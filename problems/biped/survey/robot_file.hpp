// The configuration file of a robot that nobody has described yet, from its URDF alone.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problems/biped/survey/limbs.hpp"
#include "saltus/robots/model/robot_description.hpp"

namespace saltus::survey {

struct SurveyedRobot {
  RobotDescription description;
  Limbs limbs;
  std::vector<std::string> notes;  ///< what was assumed, sentences
};

/// Feet, joints, sides and three postures: on the left foot, on the right one and on both, the CoM
/// above the middle of what stands, knees bent. Throws InputError for what the URDF lacks, or a
/// posture that its joints do not reach.
SurveyedRobot survey_robot(const UrdfModel& model);

/// As a file that read_robot_description() reads back.
std::string to_yaml(const SurveyedRobot& robot, const UrdfModel& model);

}  // namespace saltus::survey
