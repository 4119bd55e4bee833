// What does a URDF say of a humanoid that nobody has described yet: which are its feet, which
// joints move its limbs, and how are left and right named?
//
// Everything is read with all joints at zero, z of the root link up. Forward is where left is to
// the left: the names say which foot that is.
#pragma once

#include <string>
#include <vector>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::survey {

/// A foot as its shapes show it.
struct FoundFoot {
  std::string sole;                   ///< link whose axes are those of the foot
  FootRectangle rectangle;            ///< of the lowest faces, in the contact frame, m
  double contact_plane_offset = 0.0;  ///< of the contact plane along z of `sole`, m
  Vec<double, 3> origin;  ///< of the contact frame, x forward, from the root's origin, m
};

struct Limbs {
  FoundFoot left, right;
  std::vector<std::string> joints;  ///< that carry a limb and have a motor, parents first
  std::vector<std::string> legs;    ///< those among them between root and soles
  Mirror mirror;
  std::string trunk;               ///< the heaviest link that no joint of a leg moves, for pushes
  std::vector<std::string> notes;  ///< what was assumed, sentences
};

/// Throws InputError, one sentence with a remedy: no two feet are lowest, legs that are no chain of
/// joints, a joint of a leg without limits or motor, names that show no left and right.
Limbs find_limbs(const UrdfModel& model);

}  // namespace saltus::survey
