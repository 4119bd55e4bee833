#include "saltus/solver/native_solver.hpp"

#include "saltus/core/error.hpp"

namespace saltus {

const std::vector<std::pair<std::string, SolverChoice>>& solver_choices() {
  static const std::vector<std::pair<std::string, SolverChoice>> choices{
      {"riccati", SolverChoice::riccati},
      {"sparse", SolverChoice::sparse},
      {"ipopt", SolverChoice::ipopt}};
  return choices;
}

const char* name_of(SolverChoice choice) {
  for (const auto& [name, value] : solver_choices())
    if (value == choice) return name.c_str();
  return "unknown";
}

QpMethod qp_method(SolverChoice choice) {
  switch (choice) {
    case SolverChoice::sparse:
      return sparse_qp();
    case SolverChoice::riccati:
      return riccati_qp();
    case SolverChoice::ipopt:
      break;
  }
  throw DefinitionError(std::string("the solver '") + name_of(choice) +
                        "' does not use a quadratic program solver of Saltus");
}

}  // namespace saltus
