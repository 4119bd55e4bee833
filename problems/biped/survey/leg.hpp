// Hip, knee and ankle of a leg, and the direction in which the knee must bend.
//
// A flexed knee has the foot behind the thigh's line, so the knee is ahead of the line from hip to
// ankle. Forward is x of the sole.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::survey {

/// Joints of a leg, as indices of the links that they move.
struct Leg {
  int sole = -1;                        ///< link with the axes of the foot
  std::vector<int> joints;              ///< moving joints from the root to the sole
  int hip = -1, knee = -1, ankle = -1;  ///< joints whose axes are lateral, -1 if there is no knee
  double sign = 1.0;                    ///< 1 if a larger position of the knee flexes it, else -1
  double straight = 0.0;  ///< position of the knee at which hip, knee and ankle are in line, rad

  bool has_knee() const { return knee >= 0; }
  /// Flexion of the knee at the position `q` (rad): 0 if the leg is straight, negative if the knee
  /// is behind the line from hip to ankle.
  double flexion(double q) const { return sign * (q - straight); }
  /// Position of the knee with this flexion, rad.
  double position(double flexion) const { return straight + sign * flexion; }
  /// Range of the flexion for a range of positions, rad.
  Bounds flexion(const Bounds& position) const;
};

/// The knee is the joint with a lateral axis that is nearest to half the height of the leg when all
/// joints are at zero.
Leg find_leg(const robots::UrdfModel& model, const std::string& sole);

/// Distance of the knee ahead of the line from hip to ankle, along x of the sole, m. Requires a
/// knee.
double knee_ahead(const robots::UrdfModel& model, const Leg& leg, const robots::Posture& posture);

/// Lengths of thigh and shin in the plane in which the leg bends, m. Requires a knee.
Vec<double, 2> leg_lengths(const robots::UrdfModel& model, const Leg& leg);

}  // namespace saltus::survey
