// Distances between capsules, and capsules that enclose points.
#pragma once

#include <vector>

#include "saltus/robots/model/robot_description.hpp"

namespace saltus::robots {

/// The capsule moved by `pose`.
Capsule operator*(const Eigen::Isometry3d& pose, const Capsule& capsule);

/// The closest points of two segments.
struct SegmentPoints {
  Vec<double, 3> first, second;  ///< the closest points of both segments, m
};
/// The closest points of the segments (not of the surfaces), m.
SegmentPoints closest_points(const Capsule& first, const Capsule& second);

/// Fits a few capsules of small volume that together contain all `points`. A cloud thicker than 5
/// cm is cut in two where that saves at least a quarter of the volume. There are at most `most`
/// capsules, each with a radius of at least 1 mm. Throws DefinitionError without points.
std::vector<Capsule> fit_capsules(const std::vector<Vec<double, 3>>& points, int most = 4);

}  // namespace saltus::robots
