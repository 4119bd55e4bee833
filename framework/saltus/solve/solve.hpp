// Solves a problem in one call, with a default grid, integrator and solver:
//
//     const Solution plan = solve(car);
//     const Solution finer = solve(car, {.intervals_per_phase = 100,
//                                        .integrator = cvodes({.tolerance = 1e-9}),
//                                        .solver = make_ipopt()});
//
// For many solves of one problem with different data, keep a MultipleShooting and a Solver.
#pragma once

#include <concepts>
#include <memory>
#include <optional>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

struct ShootingOptions;

/// Options of the transcription and the solve.
struct SolveOptions {
  int intervals_per_phase = 30;     ///< number of intervals of every phase
  std::vector<int> intervals = {};  ///< per phase; overrides the number above
  /// Empty: runge_kutta4({.steps = 2}). For stiff dynamics use a SUNDIALS integrator.
  IntegratorChoice integrator = {};
  int threads = 1;  ///< threads that evaluate intervals: ShootingOptions::threads
  /// Empty: make_native_solver() with a scaled KKT error of 1e-8. The solver can be reused.
  std::shared_ptr<Solver> solver = {};
  /// Initial guess instead of the problem's own guess: another solution of the problem on any grid.
  std::optional<Trajectory> guess = {};
  /// Receives every iteration and can end the solve: solver/observer.hpp.
  SolveObserver observer = {};

  /// The grid and the integrator alone, for MultipleShooting(problem, options).
  operator ShootingOptions() const;  // NOLINT(google-explicit-constructor)
};

/// A solve that does not converge returns its status and message (Solution) without throwing.
/// Throws DefinitionError for invalid problems or options.
Solution solve(const OptimalControlProblem& problem, const SolveOptions& options = {});
/// The same on the grid of a MultipleShooting. Without an integrator that of SolveOptions is taken.
Solution solve_on(const OptimalControlProblem& problem, const ShootingOptions& grid);
/// The same. A template, so that braces mean SolveOptions.
template <std::same_as<ShootingOptions> Options>
Solution solve(const OptimalControlProblem& problem, const Options& grid) {
  return solve_on(problem, grid);
}

}  // namespace saltus
