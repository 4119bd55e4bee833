// Solvers that users can choose by name.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "saltus/solver/qp_method.hpp"

namespace saltus {

/// Solver of a nonlinear program.
enum class SolverChoice {
  ipopt,
  sparse,   ///< native solver; quadratic programs by sparse linear algebra
  riccati,  ///< native solver; quadratic programs stage by stage
};
/// Names in settings, for Settings::choice().
const std::vector<std::pair<std::string, SolverChoice>>& solver_choices();
/// Name in settings and results.
const char* name_of(SolverChoice choice);
/// Linear algebra of the native solver of that name. Throws DefinitionError for other solvers.
QpMethod qp_method(SolverChoice choice);

}  // namespace saltus
