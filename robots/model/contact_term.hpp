// How does a problem say that a wrench among its inputs is one that a foot can exert?
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>

#include "saltus/ocp/phase.hpp"
#include "saltus/robots/model/contact_cone.hpp"

namespace saltus {

/// The rows A w of a contact cone for the wrench that starts at input `first`.
template <int rows>
struct ConeRows {
  Mat<double, rows, 6> A;
  int first = 0;

  template <class S, int nx, int nu>
  Vec<S, rows> operator()(const S&, const Vec<S, nx>&, const Vec<S, nu>& u) const {
    // In plain numbers: Eigen's product would cost seconds of compile time, for each number of
    // rows.
    const S* w = u.data() + first;
    Vec<S, rows> values;
    for (int r = 0; r < rows; ++r) {
      const S force = A(r, 0) * w[0] + (A(r, 1) * w[1] + A(r, 2) * w[2]);
      const S torque = A(r, 3) * w[3] + (A(r, 4) * w[4] + A(r, 5) * w[5]);
      values[r] = force + torque;
    }
    return values;
  }
};

/// Keeps inputs first .. first + 5, a wrench in the axes of its sole, in the cone during the
/// window: friction, torsion and centre of pressure as one term of 3 to 12 friction edges, the
/// normal force as bounds on the input. Throws DefinitionError for another number of edges.
template <int nx, int nu, int np>
void keep_in_cone(Phase<nx, nu, np>& phase, const std::string& name, ContactConeOptions options,
                  int first, const Window& window = {}) {
  options.normal_force_rows = false;
  const ContactCone cone = contact_cone(options);
  phase.bound_input(first + 2, cone.normal_force, window);
  const auto add = [&]<int rows>(std::integral_constant<int, rows>) {
    if (cone.rows() == rows)
      phase.keep(name, ConeRows<rows>{cone.fixed<rows>(), first}, at_most(0.0), window);
    return cone.rows() == rows;
  };
  // The size of a term is part of its type, so the usual numbers of edges are spelt out.
  constexpr int others = 6;  // torsion 2, centre of pressure 4
  const bool added = add(std::integral_constant<int, 3 + others>{}) ||
                     add(std::integral_constant<int, 4 + others>{}) ||
                     add(std::integral_constant<int, 6 + others>{}) ||
                     add(std::integral_constant<int, 8 + others>{}) ||
                     add(std::integral_constant<int, 12 + others>{});
  if (!added)
    throw DefinitionError(fmt::format(
        "term '{}': a friction pyramid of {} edges; use 3, 4, 6, 8 or 12", name, options.edges));
}

}  // namespace saltus
