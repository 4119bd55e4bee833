#include "saltus/robots/walking/planner.hpp"

namespace saltus::robots::walking {

ContactCone::Options cone_options(const ContactSettings& contact, const FootRectangle& foot) {
  ContactCone::Options options;
  options.friction = contact.friction;
  options.edges = contact.edges;
  options.pyramid = contact.pyramid;
  options.foot = foot;
  options.torsional_friction = contact.torsional_friction;
  options.corners = contact.corners;
  options.normal_force = between(contact.normal_force_min, contact.normal_force_max);
  return options;
}

}  // namespace saltus::robots::walking
