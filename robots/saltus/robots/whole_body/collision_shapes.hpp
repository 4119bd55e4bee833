// What fills the links of a robot, and which of them must not touch.
#pragma once

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus {

/// Gives the bodies their capsules: those of `description`, else capsules fitted to what the URDF
/// shows of each link (its meshes are read: about half a second for iCub), where that is not there
/// to what collides, else to the box of the link's inertia. Then names the pairs that must stay
/// apart: all but a body and its parent, and bodies at most four joints apart that are nearer than
/// 1 cm at rest by construction (every joint at zero, or at the limit nearest to it). Throws
/// InputError for a mesh that cannot be read, and for a capsule on a link that is not there.
void add_capsules(FloatingRobot& robot, const UrdfModel& model,
                  const RobotDescription& description);

/// Throws InputError, naming the deepest pair, if capsules that must stay apart overlap in `state`.
void expect_apart(const FloatingRobot& robot, const WholeBodyState& state,
                  const std::string& posture);

}  // namespace saltus
