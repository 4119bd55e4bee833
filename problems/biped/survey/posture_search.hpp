// Finds a posture with given places of feet and CoM and with clearance between limbs: inverse
// kinematics by a damped Gauss-Newton method within the joint limits.
#pragma once

#include <string>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::survey {

/// Desired posture. Positions in m, in the contact frame of the stance foot.
struct PostureWish {
  robots::Side stance = robots::Side::left;            ///< foot whose sole is flat on the ground
  Vec<double, 3> other_foot = Vec<double, 3>::Zero();  ///< origin of the other sole, also flat
  Vec<double, 2> com = Vec<double, 2>::Zero();         ///< horizontal position of the CoM
  double trunk_height = 0.0;  ///< desired height of the root link's origin (soft)
  double clearance = 0.02;    ///< desired distance between limbs with capsules
  double rest_weight = 0.1;   ///< weight of the joints' distance from the start; soft
};

struct FoundPosture {
  robots::Posture joints;       ///< rad
  double foot_error = 0.0;      ///< position error of the other foot, m
  double tilt = 0.0;            ///< angle of the other sole to the ground, rad
  double com_error = 0.0;       ///< horizontal error of the CoM, m
  double clearance = infinity;  ///< between the nearest limbs, m; negative if they overlap

  /// True if the errors are small: feet to 0.1 mm and 1 mrad, CoM to 1 mm.
  bool is_found() const { return foot_error < 1e-4 && tilt < 1e-3 && com_error < 1e-3; }
};

/// Moves the joints of `body` (made from `model`) within their limits, from `start`. Joints that
/// `start` does not name begin at zero. Prefers an upright root link and joints near `start`, as
/// far as `wish` permits.
FoundPosture find_posture(const robots::UrdfModel& model, const robots::RobotDescription& robot,
                          const robots::FloatingRobot& body, const PostureWish& wish,
                          const robots::Posture& start);

}  // namespace saltus::survey
