// Assumptions of the controllers on the contact of a foot with the ground.
#pragma once

#include "saltus/robots/model/contact_cone.hpp"

namespace saltus::walking {

/// Limits of the contact wrench of one foot.
struct ContactSettings {
  double friction = 1.0 / 3.0;                           ///< Coulomb friction coefficient
  int edges = 6;                                         ///< edges of the friction pyramid
  FrictionPyramid pyramid = FrictionPyramid::inscribed;  ///< inscribed or circumscribed
  double torsional_friction = 0.0133;                    ///< m
  bool corners = false;              ///< limit torsion to the forces at the foot's corners
  double normal_force_min = 10.0;    ///< N
  double normal_force_max = 1000.0;  ///< N per foot
};

/// Options of the contact cone of one foot.
ContactConeOptions cone_options(const ContactSettings& contact, const FootRectangle& foot);

}  // namespace saltus::walking
