// Constraint terms that keep a contact wrench among the inputs inside the contact cone of a foot.
#pragma once

#include <string>
#include <utility>

#include "saltus/ocp/phase.hpp"
#include "saltus/robots/model/contact_cone.hpp"

namespace saltus {

/// The rows A w of a contact cone, for the wrench w that starts at entry `first` of z. The function
/// is affine with any number of rows. It is not written as a formula, which would be compiled for
/// each number of rows and each problem.
Function cone_rows(const ContactCone& cone, const Arguments& sizes, int first);

/// Keeps the inputs first .. first + 5, a wrench in the axes of its sole, in the cone during the
/// window. Friction, torsion and centre of pressure become one term, the normal force becomes
/// bounds on the input.
template <int nx, int nu, int np>
void keep_in_cone(Phase<nx, nu, np>& phase, const std::string& name, ContactCone::Options options,
                  int first, const Window& window = {}) {
  options.normal_force_rows = false;
  const ContactCone cone = contact_cone(options);
  const Arguments sizes = phase.definition().sizes;
  phase.bound_input(first + 2, cone.normal_force, window)
      .keep(name, cone_rows(cone, sizes, sizes.u(first)), at_most(0.0), window);
}

}  // namespace saltus
