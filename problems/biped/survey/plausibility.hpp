// Plausibility of a URDF, which may be valid and yet not describe the robot: other units, different
// sides, knees that bend the wrong way, coupled joints, and frozen joints outside their limits.
#pragma once

#include <vector>

#include "problems/biped/survey/robot_check.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::survey {

/// Appends the findings. `body` is made from `model` and `robot`, with capsules if it has any.
///
/// - Units: a body is not denser than lead, its radius of gyration fits its shape, and mass and
///   height fit a humanoid.
/// - Joints: joints that follow others do not move, frozen joints are within their limits.
/// - Sides: masses, places of the CoM, limits and axes of the left and right limbs, and the lengths
///   of thigh and shin, are mirror images.
/// - Knees: they bend forward, by their limits and in every posture, as the toes point.
void check_plausibility(const robots::UrdfModel& model, const robots::RobotDescription& robot,
                        const robots::FloatingRobot& body, std::vector<Finding>& findings);

}  // namespace saltus::survey
