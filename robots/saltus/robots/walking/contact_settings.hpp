// What the controllers assume of the contact of either foot with the ground.
#pragma once

#include "saltus/robots/model/contact_cone.hpp"

namespace saltus::walking {

/// What the ground can do to a foot, as the planner has it.
struct ContactSettings {
  double friction = 1.0 / 3.0;                           ///< Coulomb's coefficient
  int edges = 6;                                         ///< of the friction pyramid
  FrictionPyramid pyramid = FrictionPyramid::inscribed;  ///< inside of the cone, or around it
  double torsional_friction = 0.0133;                    ///< m
  bool corners = false;              ///< no more torsion than the foot's corners can exert
  double normal_force_min = 10.0;    ///< N
  double normal_force_max = 1000.0;  ///< N per foot
};

/// Of one foot.
ContactConeOptions cone_options(const ContactSettings& contact, const FootRectangle& foot);

}  // namespace saltus::walking
