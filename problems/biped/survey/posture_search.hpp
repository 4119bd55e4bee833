// A posture in which the feet are where they shall be, the CoM is above the sole and limbs keep off
// each other: inverse kinematics by a damped Gauss-Newton method within the joints' limits.
#pragma once

#include <string>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::survey {

/// What is asked for. Positions in m, in the contact frame of the foot that stands.
struct PostureWish {
  Side stance = Side::left;                            ///< its sole is flat on the ground
  Vec<double, 3> other_foot = Vec<double, 3>::Zero();  ///< of the other contact frame, flat too
  Vec<double, 2> com = Vec<double, 2>::Zero();         ///< above this point of the ground
  double trunk_height = 0.0;  ///< of the root link's origin, as near as can be
  double clearance = 0.02;    ///< between limbs that have capsules
};

struct FoundPosture {
  Posture joints;               ///< rad
  double foot_error = 0.0;      ///< of the other foot's place, m
  double tilt = 0.0;            ///< of the other sole against the ground, rad
  double com_error = 0.0;       ///< of the CoM along the ground, m
  double clearance = infinity;  ///< between the nearest limbs, m; < 0 where they overlap

  /// To what a robot needs: feet to 0.1 mm and 1 mrad, CoM to 1 mm.
  bool is_found() const { return foot_error < 1e-4 && tilt < 1e-3 && com_error < 1e-3; }
};

/// Moves the motors of `body` (made of `model`; all within their limits) from `start`, where joints
/// that are not named are at zero. The root link is kept upright, and joints near `start`, as far
/// as the wishes leave room.
FoundPosture find_posture(const UrdfModel& model, const RobotDescription& robot,
                          const FloatingRobot& body, const PostureWish& wish, const Posture& start);

}  // namespace saltus::survey
