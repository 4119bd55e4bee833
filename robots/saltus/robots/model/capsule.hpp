// Capsules: all points within a radius of a segment. The shape of limbs for those who ask how far
// apart they are.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

/// A segment with a radius: all points that are no farther from it.
struct Capsule {
  Vec<double, 3> from = Vec<double, 3>::Zero(), to = Vec<double, 3>::Zero();  ///< m; may be equal
  double radius = 0.0;                                                        ///< m

  /// Of the segment, m.
  Vec<double, 3> middle() const { return 0.5 * (from + to); }
  double length() const { return (to - from).norm(); }  ///< of the segment, m
  double volume() const;                                ///< m^3
};

/// The capsule, moved.
Capsule operator*(const Eigen::Isometry3d& pose, const Capsule& capsule);

/// A capsule fixed to a link, in the link's frame.
struct LinkCapsule {
  std::string link;  ///< that carries it
  Capsule capsule;   ///< in the link frame
};

/// The points of two segments that are closest to each other.
struct SegmentPoints {
  Vec<double, 3> first, second;  ///< the closest points of both segments, m
};
/// The closest points of the segments (not of the surfaces), m.
SegmentPoints closest_points(const Capsule& first, const Capsule& second);

/// Few capsules that together hold all `points`, of little volume: one, or more where cutting a
/// cloud thicker than 5 cm in two saves at least a quarter of the volume; at most `most`, none
/// thinner than 1 mm. Throws
/// DefinitionError without points.
std::vector<Capsule> fit_capsules(const std::vector<Vec<double, 3>>& points, int most = 4);

}  // namespace saltus
