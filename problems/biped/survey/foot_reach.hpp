// Reachable places of a robot's feet from its kinematics: joint limits, no collision of the legs,
// and a trunk near its standing height, as the pendulum model of walking assumes.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::survey {

/// Reachable places of the origin of a contact frame, (forward, away from the other leg), m.
/// Corners are in the order of the search directions. The polygons are inner approximations: the
/// search found a posture for each corner and for the middle.
struct FootReach {
  std::vector<robots::Point2> from_foot;  ///< relative to the other foot, CoM above the midpoint
  std::vector<robots::Point2> from_com;   ///< relative to the CoM, other foot below the CoM
};

inline constexpr int reach_directions = 8;

/// Finds both by bisection along `reach_directions` rays, with inverse kinematics at each place
/// (posture_search.hpp). Takes seconds. Empty if the robot does not reach its own nominal place.
std::optional<FootReach> find_foot_reach(const robots::UrdfModel& model,
                                         const robots::RobotDescription& robot);

/// Reads the reach from a file in the folder if it matches this URDF and description. Otherwise
/// searches and writes the file. If the folder is not writable, every call searches.
std::optional<FootReach> cached_foot_reach(const robots::UrdfModel& model,
                                           const robots::RobotDescription& robot,
                                           const std::filesystem::path& folder);

}  // namespace saltus::survey
