// Creates any solver of nonlinear programs by name, for applications with a solver option. Needs
// Ipopt.
#pragma once

#include <memory>

#include "saltus/solver/solver.hpp"
#include "saltus/solver/solver_choice.hpp"

namespace saltus {

/// Options that every solver supports.
struct SolverLimits {
  double tolerance = 1e-8;   ///< scaled KKT error
  int max_iterations = 500;  ///< iteration limit
  double time_limit = 0.0;   ///< wall-clock limit in seconds; 0: none
};
/// Creates the chosen solver with these limits.
std::unique_ptr<Solver> make_solver(SolverChoice choice, const SolverLimits& limits = {});

}  // namespace saltus
