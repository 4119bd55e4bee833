// Why can a problem not be met, by how much, and what would help?
//
//     const Solution plan = solve(problem);
//     if (plan.status == SolveStatus::infeasible) std::cout << explain(problem).text();
//
// The least relaxation (solver/elastic_program.hpp) of what is asked for: hard terms, bounds of
// states, links, integrals, the closing and the total time, each divided by its nominal value.
// Dynamics, jumps, the start, inputs and durations are not negotiable there; what they could give
// follows from the multipliers of that optimum, and each answer is carried out before it is given.
//
// A controller's tick is explained afterwards: explain(present_problem(controller.shooting())).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "saltus/solve/problem_change.hpp"
#include "saltus/solver/elastic_program.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// What is missing of one side of a term, wherever it acts: so far its bound would have to give.
struct Shortage {
  /// "term", "state", "integral", "link", "closing" or "total time".
  std::string kind;
  std::string phase;                                      ///< empty where it belongs to none
  std::string term;                                       ///< of a state's bounds "state 1"
  int component = 0;                                      ///< row of the term
  ProblemChange::Side side = ProblemChange::Side::upper;  ///< that is missed
  double amount = 0.0;                                    ///< in the term's own units, positive
  double nominal = 1.0;                                   ///< what counts as one of them
  double time = 0.0;                                      ///< s, where it is held up most
  double value = 0.0;                                     ///< there
  double bound = 0.0;                                     ///< that it misses
  bool is_exact = false;                                  ///< both bounds are one

  /// "phase 'ride', term 'there'"
  std::string name() const;
  /// The sentence: name, amount, time, value and bound.
  std::string text() const;
};

/// Changes of the problem after which it can be met.
struct Remedy {
  std::vector<ProblemChange> changes;  ///< all of them together
  std::string text;  ///< "with the duration of phase 'ride' 2.6 s in place of 2 s"
  /// Of the problem with the changes, solved: a remedy is one only if that worked.
  SolveStatus status = SolveStatus::invalid_problem;
  double cost = 0.0;  ///< of it
  /// Of the change over the value before, or over its nominal magnitude where that is zero.
  double effort = 0.0;
};

/// What explain() finds.
struct Explanation {
  /// Of the elastic program; only an optimum explains anything.
  SolveStatus status = SolveStatus::invalid_problem;
  /// sum of amounts over nominal values.
  double relaxation = 0.0;
  std::vector<Shortage> shortages;  ///< the largest first, relative to nominal values
  std::vector<Remedy> remedies;     ///< the least effort first; then the shortages themselves
  Trajectory trajectory;            ///< with the least relaxation
  int solves = 0;                   ///< of elastic programs and of changed problems
  double seconds = 0.0;             ///< wall clock

  /// Whether the least relaxation is known, and is one.
  bool ok() const { return is_success(status); }
  /// Whether something is missing.
  bool is_infeasible() const { return ok() && !shortages.empty(); }
  /// A sentence per shortage, and one with the remedies.
  std::string text() const;
};

/// How explain() looks.
struct ExplainOptions {
  ShootingOptions shooting = {};  ///< without an integrator Runge-Kutta 4 in two steps
  int remedies = 3;               ///< at most, besides the shortages themselves; 0: none looked for
  double time_limit = 20.0;       ///< s of wall clock, 0: none
  /// Makes what solves; empty: make_sqp() to 1e-9.
  std::function<std::unique_ptr<Solver>()> make_solver = {};
  /// Where the search begins, beside the problem's own guess: the trajectory of a failed solve.
  std::optional<Trajectory> guess = {};
};

/// Throws DefinitionError where the problem or the options are wrong. Where functions are not
/// convex, the relaxation is the least near the guess.
Explanation explain(const OptimalControlProblem& problem, const ExplainOptions& options = {});

/// What is asked for, as groups of rows and bounds of the shooting's program; nominal values are
/// what nominal changes of the variables do to a term at w, at most. For comparing solvers.
std::vector<ElasticGroup> elastic_groups(MultipleShooting& shooting, const VectorXd& w);

}  // namespace saltus
