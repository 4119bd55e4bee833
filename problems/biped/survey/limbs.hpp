// Finds the feet of a humanoid, the joints of its limbs, and the names of left and right from its
// URDF alone.
//
// The search uses the pose with all joints at zero and z of the root link up. The names tell which
// foot is the left one; its side defines the forward direction.
#pragma once

#include <string>
#include <vector>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::survey {

/// A foot, as found from its collision shapes.
struct FoundFoot {
  std::string sole;                   ///< link with the axes of the foot
  robots::FootRectangle rectangle;    ///< extent of the lowest faces, contact frame, m
  double contact_plane_offset = 0.0;  ///< contact plane along z of `sole`, m
  Vec<double, 3> origin;  ///< contact frame, x forward, relative to the root's origin, m
};

struct Limbs {
  FoundFoot left, right;
  std::vector<std::string> joints;  ///< actuated joints that carry a limb, parents first
  std::vector<std::string> legs;    ///< those of them between root and soles
  robots::RobotDescription::Mirror mirror;
  std::string trunk;               ///< heaviest link that no leg joint moves; pushes act on it
  std::vector<std::string> notes;  ///< assumptions, one sentence each
};

/// Throws InputError with a remedy if there are no two lowest feet, a leg is not a chain of joints,
/// a leg joint has no limits or no motor, or the names do not show left and right.
Limbs find_limbs(const robots::UrdfModel& model);

}  // namespace saltus::survey
