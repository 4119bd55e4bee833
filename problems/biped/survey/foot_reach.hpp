// Where can a robot put its feet? From its kinematics: joint limits, legs that must not meet, a
// trunk that keeps its height as far as walking pendulums let it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/support_polygon.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::survey {

/// Places of the origin of a contact frame, (forward, away from the other leg), m; corners in the
/// order of the directions in which they were looked for. Inner approximations: each corner was
/// reached, and so was the middle.
struct FootReach {
  std::vector<Point2> from_foot;  ///< relative to the other foot, CoM above the middle of both
  std::vector<Point2> from_com;   ///< relative to the CoM, the other foot beneath it
};

inline constexpr int reach_directions = 8;

/// Looks for both along `reach_directions` rays by bisection, inverse kinematics at each place
/// (posture_search.hpp): some seconds. Nothing where the robot does not reach its own usual place.
std::optional<FootReach> find_foot_reach(const UrdfModel& model, const RobotDescription& robot);

/// The same from a file of the folder, if it is that of this URDF and description; else it is
/// found and written there. A folder that cannot be written to costs the search every time.
std::optional<FootReach> cached_foot_reach(const UrdfModel& model, const RobotDescription& robot,
                                           const std::filesystem::path& folder);

}  // namespace saltus::survey
