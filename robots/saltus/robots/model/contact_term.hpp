// How does a problem say that a wrench among its inputs is one that a foot can exert?
#pragma once

#include <string>
#include <utility>

#include "saltus/ocp/phase.hpp"
#include "saltus/robots/model/contact_cone.hpp"

namespace saltus {

/// The rows A w of a contact cone for the wrench w that starts at entry `first` of z. Affine and of
/// any number of rows, so it is no formula that would be compiled for each number and problem.
Function cone_rows(const ContactCone& cone, const Arguments& sizes, int first);

/// Keeps inputs first .. first + 5, a wrench in the axes of its sole, in the cone during the
/// window: friction, torsion and centre of pressure as one term, the normal force as bounds on the
/// input.
template <int nx, int nu, int np>
void keep_in_cone(Phase<nx, nu, np>& phase, const std::string& name, ContactConeOptions options,
                  int first, const Window& window = {}) {
  options.normal_force_rows = false;
  const ContactCone cone = contact_cone(options);
  const Arguments sizes = phase.definition().sizes;
  phase.bound_input(first + 2, cone.normal_force, window)
      .keep(name, cone_rows(cone, sizes, sizes.u(first)), at_most(0.0), window);
}

}  // namespace saltus
