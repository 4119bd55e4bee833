// All solvers of nonlinear programs by name, for programs that let their users choose. Needs Ipopt.
#pragma once

#include <memory>

#include "saltus/solver/solver.hpp"
#include "saltus/solver/solver_choice.hpp"

namespace saltus {

/// What every solver can be asked for.
struct SolverLimits {
  double tolerance = 1e-8;   ///< scaled KKT error
  int max_iterations = 500;  ///< after which the solver gives up
  double time_limit = 0.0;   ///< s of wall clock, 0: none
};
/// The solver that is chosen, with these limits.
std::unique_ptr<Solver> make_solver(SolverChoice choice, const SolverLimits& limits = {});

}  // namespace saltus
