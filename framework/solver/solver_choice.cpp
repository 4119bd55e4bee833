#include "saltus/solver/solver_choice.hpp"

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

}  // namespace saltus
