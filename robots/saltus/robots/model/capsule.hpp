// Capsules: all points within a radius of a segment. They approximate limbs in distance
// computations.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

/// All points whose distance from a segment is at most `radius`.
struct Capsule {
  Vec<double, 3> from = Vec<double, 3>::Zero(), to = Vec<double, 3>::Zero();  ///< m; may be equal
  double radius = 0.0;                                                        ///< m

  /// Midpoint of the segment, m.
  Vec<double, 3> middle() const { return 0.5 * (from + to); }
  double length() const { return (to - from).norm(); }  ///< length of the segment, m
  double volume() const;                                ///< m^3
};

/// The capsule moved by `pose`.
Capsule operator*(const Eigen::Isometry3d& pose, const Capsule& capsule);

/// A capsule fixed to a link, in the link's frame.
struct LinkCapsule {
  std::string link;  ///< name of the link
  Capsule capsule;   ///< shape, in the link frame
};

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

}  // namespace saltus
