// Several starts of one problem, on all processors: which optima there are, and which start leads
// to which.
//
//     const SeveralSolutions found = solve_from(car, {{.durations = {5.0, 2.0}},
//                                                     {.durations = {1.0, 9.0}}});
//     found.optima.front().cost;      // the best
//
// A local solver ends where its start leads it; nothing is known of optima that no start led to.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/solve/solve.hpp"

namespace saltus {

/// Where one search begins. What is empty is as the problem guesses it.
struct StartingPoint {
  std::vector<double> durations = {};           ///< of all phases, s; of fixed ones not read
  std::vector<Guess> states = {}, inputs = {};  ///< per phase, over the fraction of its duration
  std::optional<Trajectory> trajectory = {};    ///< another solution; the others then count on top
};

/// How a problem is solved from several starts.
struct SeveralStartsOptions {
  int intervals_per_phase = 30;      ///< of every phase
  std::vector<int> intervals = {};   ///< per phase, in place of the number above
  IntegratorChoice integrator = {};  ///< empty: runge_kutta4({.steps = 2})
  /// Called once for every start; empty: make_sqp().
  std::function<std::unique_ptr<Solver>()> make_solver = {};
  int threads = 0;  ///< 0: as many as there are processors
  /// Two optima are one where no variable differs by more, in nominal magnitudes or, where none are
  /// declared, relative to the largest of its quantity in both, and the costs by no more than
  /// `same_cost`, relative to the larger one.
  double same_point = 1e-3;
  double same_cost = 1e-6;  ///< relative: what is closer is one optimum
};

/// What several starts gave.
struct SeveralSolutions {
  /// Distinct ones, the cheapest first; of those that count as one the cheapest.
  std::vector<Solution> optima;
  std::vector<int> optimum_of;   ///< per start: its place in `optima`; -1: the solver found none
  std::vector<Solution> failed;  ///< of these starts, in their order

  /// Whether any start led to an optimum.
  bool ok() const { return !optima.empty(); }
};

/// The result does not depend on the number of threads. Throws DefinitionError when problem,
/// options or a start are wrong, before anything is solved.
SeveralSolutions solve_from(const OptimalControlProblem& problem,
                            const std::vector<StartingPoint>& starts,
                            const SeveralStartsOptions& options = {});

}  // namespace saltus
