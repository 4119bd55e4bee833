// Collision capsules of a robot's links, and the pairs of them that must not touch.
#pragma once

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus {

/// Sets the capsules of the bodies and the pairs that must stay apart.
///
/// Capsules come from `description`. Without it they are fitted to the visual shapes of each link
/// (reading its meshes takes about half a second for iCub), else to its collision shapes, else to
/// the box of its inertia. All pairs must stay apart, except a body and its parent, and bodies at
/// most four joints apart that are nearer than 1 cm at rest (every joint at zero, or at the limit
/// nearest to it). Throws InputError for a mesh that cannot be read, and for a capsule on an
/// unknown link.
void add_capsules(FloatingRobot& robot, const UrdfModel& model,
                  const RobotDescription& description);

/// Throws InputError, naming the pair with the deepest overlap, if capsules that must stay apart
/// overlap in `state`.
void expect_apart(const FloatingRobot& robot, const WholeBodyState& state,
                  const std::string& posture);

}  // namespace saltus
