// Solves one problem from several starts in parallel, and reports the distinct optima and which
// start led to which.
//
//     const SeveralSolutions found = solve_from(car, {{.durations = {5.0, 2.0}},
//                                                     {.durations = {1.0, 9.0}}});
//     found.optima.front().cost;      // the best
//
// A local solver converges near its start. Optima that no start leads to stay unknown.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/solve/solve.hpp"

namespace saltus {

/// One start. Empty fields use the guess of the problem.
struct StartingPoint {
  std::vector<double> durations = {};  ///< of all phases in seconds; fixed ones are not read
  std::vector<Guess> states = {}, inputs = {};  ///< per phase, over the fraction of its duration
  std::optional<Trajectory> trajectory = {};  ///< another solution; the other fields override parts
                                              ///< of it
};

/// Options of solve_from().
struct SeveralStartsOptions {
  int intervals_per_phase = 30;      ///< number of intervals of every phase
  std::vector<int> intervals = {};   ///< per phase; overrides the number above
  IntegratorChoice integrator = {};  ///< empty: runge_kutta4({.steps = 2})
  /// Called once per start; empty: make_native_solver().
  std::function<std::unique_ptr<Solver>()> make_solver = {};
  int threads = 0;  ///< 0: number of processors
  /// Two results are the same optimum if no variable differs by more than this and the costs differ
  /// by at most `same_cost`. Differences are in nominal magnitudes or, if none are declared,
  /// relative to the largest value of the quantity in both.
  double same_point = 1e-3;
  double same_cost = 1e-6;  ///< relative difference of the costs
};

/// Result of several starts.
struct SeveralSolutions {
  /// Distinct optima, lowest cost first; each is the cheapest of its duplicates.
  std::vector<Solution> optima;
  std::vector<int> optimum_of;   ///< per start: index in `optima`; -1: no optimum found
  std::vector<Solution> failed;  ///< results of those starts, in order

  /// True if any start led to an optimum.
  bool ok() const { return !optima.empty(); }
};

/// The result does not depend on the number of threads. Throws DefinitionError for an invalid
/// problem, option or start before anything is solved.
SeveralSolutions solve_from(const OptimalControlProblem& problem,
                            const std::vector<StartingPoint>& starts,
                            const SeveralStartsOptions& options = {});

}  // namespace saltus
