// The solvers a user can choose among, by name.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "saltus/solver/qp_method.hpp"

namespace saltus {

/// Which solver.
enum class SolverChoice {
  ipopt,
  sparse,   ///< our own, quadratic programs by sparse linear algebra
  riccati,  ///< our own, quadratic programs stage by stage
};
/// As users write them, for Settings::choice().
const std::vector<std::pair<std::string, SolverChoice>>& solver_choices();
/// As settings and results have it.
const char* name_of(SolverChoice choice);
/// How our own solvers of that name solve their quadratic programs; DefinitionError of others.
QpMethod qp_method(SolverChoice choice);

}  // namespace saltus
