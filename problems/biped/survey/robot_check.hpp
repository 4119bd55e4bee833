// Checks that the description of a robot suffices for standing, pushes and steps.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::survey {

/// Result of one check.
struct Finding {
  enum class Level { good, note, wrong };
  Level level = Level::good;
  std::string subject;  ///< "masses", "feet", ...
  std::string text;     ///< the finding, and a remedy unless it is good
};

/// Checks masses, inertias, joint limits, meshes and feet. In every posture the CoM must be above
/// the support and limbs apart. The legs must reach the edges of the step region (`forward` and
/// `sideways`, m). Throws InputError only for files that cannot be read.
std::vector<Finding> check_robot(const robots::UrdfModel& model,
                                 const robots::RobotDescription& robot, double forward,
                                 Bounds sideways);

/// One line per finding; `wrong` ones include their remedy.
std::string describe(std::span<const Finding> findings);

}  // namespace saltus::survey
