// Is a robot described well enough to be stood, pushed and stepped with?
#pragma once

#include <span>
#include <string>
#include <vector>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::survey {

/// One thing that was looked at.
struct Finding {
  enum class Level { good, note, wrong };
  Level level = Level::good;
  std::string subject;  ///< "masses", "feet", ...
  std::string text;     ///< what was found, and the remedy if it is not good
};

/// Masses and inertias, limits of the joints, meshes, feet, every posture with the CoM over what
/// stands and limbs apart, and reach: whether the legs get to the edges of the region of steps
/// (`forward` and `sideways`, m). Throws InputError only for what cannot be read at all.
std::vector<Finding> check_robot(const UrdfModel& model, const RobotDescription& robot,
                                 double forward, Bounds sideways);

/// A line per finding, the wrong ones with their remedy.
std::string describe(std::span<const Finding> findings);

}  // namespace saltus::survey
