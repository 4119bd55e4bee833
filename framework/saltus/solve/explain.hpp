// Explains why a problem is infeasible, by how much, and what would help; and why a soft term is
// violated at the optimum.
//
//     const Solution plan = solve(problem);
//     if (plan.status == SolveStatus::infeasible) std::cout << explain(problem).text();
//
// explain() computes the least relaxation (solver/elastic_program.hpp) of the negotiable
// constraints: hard terms, bounds of states, links, integrals, the closing and the total time, each
// divided by its nominal value. Dynamics, jumps, the start, inputs and durations are not relaxed.
// Multipliers of the relaxed optimum show how they could help. Each remedy is verified by a solve
// before it is reported.
//
// If all of these are feasible, the problem is solved and each violated soft term is examined:
// could it hold as a hard term? If not, explain() reports the least shortage and what would help.
// If so, it reports the cost of holding it, the cost term that outweighs it, and the weight that
// makes it hold.
//
// A controller tick can be explained afterwards: explain(present_problem(controller.shooting())).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "saltus/solve/explanation.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// Options of explain().
struct ExplainOptions {
  ShootingOptions shooting = {};  ///< default integrator: Runge-Kutta 4 in two steps
  int remedies = 3;               ///< largest number besides the shortages themselves; 0: none
  double time_limit = 20.0;       ///< wall-clock limit in seconds; 0: none
  /// Factory for the solver; empty: make_native_solver() with tolerance 1e-9.
  std::function<std::unique_ptr<Solver>()> make_solver = {};
  /// Additional initial guess, such as the trajectory of a failed solve.
  std::optional<Trajectory> guess = {};
  bool soft_terms = true;  ///< explain violated soft terms too
  /// True if a number may be changed by a remedy (`by` is not read); false, for example, for
  /// measured values. Empty: every number may change.
  std::function<bool(const ProblemChange&)> may_change = {};
};

/// Throws DefinitionError for invalid problems or options. If functions are not convex, the
/// relaxation is a local minimum near the guess.
Explanation explain(const OptimalControlProblem& problem, const ExplainOptions& options = {});

}  // namespace saltus
