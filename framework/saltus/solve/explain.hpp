// Why can a problem not be met, by how much, and what would help? Why does a soft term give way?
//
//     const Solution plan = solve(problem);
//     if (plan.status == SolveStatus::infeasible) std::cout << explain(problem).text();
//
// The least relaxation (solver/elastic_program.hpp) of what is asked for: hard terms, bounds of
// states, links, integrals, the closing and the total time, each divided by its nominal value.
// Dynamics, jumps, the start, inputs and durations are not negotiable there; what they could give
// follows from the multipliers of that optimum, and each answer is carried out before it is given.
//
// Where all that can be met, the problem is solved, and soft terms that give way are asked in turn:
// could they hold, as hard terms? If not, what is missing at least, and what would help; if so,
// what that would cost, which cost they give way to, and the weight from which on they hold.
//
// A controller's tick is explained afterwards: explain(present_problem(controller.shooting())).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "saltus/solve/explanation.hpp"
#include "saltus/solver/elastic_program.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// How explain() looks.
struct ExplainOptions {
  ShootingOptions shooting = {};  ///< without an integrator Runge-Kutta 4 in two steps
  int remedies = 3;               ///< at most, besides the shortages themselves; 0: none looked for
  double time_limit = 20.0;       ///< s of wall clock, 0: none
  /// Makes what solves; empty: make_sqp() to 1e-9.
  std::function<std::unique_ptr<Solver>()> make_solver = {};
  /// Where the search begins, beside the problem's own guess: the trajectory of a failed solve.
  std::optional<Trajectory> guess = {};
  bool soft_terms = true;  ///< whether those that give way are explained, too
  /// Whether a number may be proposed to change (its `by` is not read), e.g. none that was
  /// measured; empty: each may.
  std::function<bool(const ProblemChange&)> may_change = {};
};

/// Throws DefinitionError where the problem or the options are wrong. Where functions are not
/// convex, the relaxation is the least near the guess.
Explanation explain(const OptimalControlProblem& problem, const ExplainOptions& options = {});

/// What is asked for, as groups of rows and bounds of the shooting's program; nominal values are
/// what nominal changes of the variables do to a term at w, at most. For comparing solvers.
std::vector<ElasticGroup> elastic_groups(MultipleShooting& shooting, const VectorXd& w);

}  // namespace saltus
