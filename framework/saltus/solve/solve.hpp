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
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
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
  /// Receives every iteration and can end the solve: solver/solver.hpp.
  SolveObserver observer = {};

  /// The grid and the integrator alone, for MultipleShooting(problem, options).
  operator ShootingOptions() const;  // NOLINT(google-explicit-constructor)
};

/// A solve that does not converge returns its status and message (Solution) without throwing.
/// Throws DefinitionError for invalid problems or options.
Solution solve(const OptimalControlProblem& problem, const SolveOptions& options = {});
/// The same on the grid of a MultipleShooting. If `grid` has no integrator, the default of
/// SolveOptions applies.
Solution solve_on(const OptimalControlProblem& problem, const ShootingOptions& grid);
/// The same. This function is a template so that braces select SolveOptions.
template <std::same_as<ShootingOptions> Options>
Solution solve(const OptimalControlProblem& problem, const Options& grid) {
  return solve_on(problem, grid);
}

// Solves one problem from several starts in parallel, and reports the distinct optima and which
// start led to which.
//
//     const SeveralSolutions found = solve_from(car, {{.durations = {5.0, 2.0}},
//                                                     {.durations = {1.0, 9.0}}});
//     found.optima.front().cost;      // the best
//
// A local solver converges near its start. An optimum to which no start leads is not found.

/// Result of several starts.
struct SeveralSolutions {
  /// Options of solve_from().
  struct Options {
    int intervals_per_phase = 30;      ///< number of intervals of every phase
    std::vector<int> intervals = {};   ///< per phase; overrides the number above
    IntegratorChoice integrator = {};  ///< empty: runge_kutta4({.steps = 2})
    /// Called once per start; empty: make_native_solver().
    std::function<std::unique_ptr<Solver>()> make_solver = {};
    int threads = 0;  ///< 0: number of processors
    /// Two results are the same optimum if no variable differs by more than this and the costs
    /// differ by at most `same_cost`. Differences are in nominal magnitudes or, if none are
    /// declared, relative to the largest value of the quantity in both.
    double same_point = 1e-3;
    double same_cost = 1e-6;  ///< relative difference of the costs
  };

  /// One start. Empty fields use the guess of the problem.
  struct Start {
    std::vector<double> durations = {};  ///< one per phase, in seconds; fixed ones are not read
    std::vector<Guess> states = {}, inputs = {};  ///< per phase, over the fraction of its duration
    std::optional<Trajectory> trajectory = {};    ///< another solution; the other fields override
                                                  ///< parts of it
  };

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
                            const std::vector<SeveralSolutions::Start>& starts,
                            const SeveralSolutions::Options& options = {});

// Homotopy: a parameter moves in steps from an easy value to the wanted one, and each solution is
// the start of the next solve.
//
//     MultipleShooting shooting(swing_up, options);
//     const Homotopy way = solve_along(shooting, *solver, "gravity", no_gravity, earth);
//     if (way.ok()) way.solution.cost;

/// Options of a homotopy.
struct HomotopyOptions {
  double first_step = 0.25;  ///< fraction of the path; doubled on success, halved on failure
  double least_step = 1e-3;  ///< the homotopy fails below this step
};

/// Result of a homotopy.
struct Homotopy {
  Solution solution;     ///< at `reached`; if the first solve failed, the result of that solve
  double reached = 0.0;  ///< fraction of the path; 1: complete
  /// One solve of the homotopy.
  struct Step {
    double at = 0.0;      ///< fraction of the path
    double cost = 0.0;    ///< cost of the solution
    bool solved = false;  ///< the solve succeeded
    int iterations = 0;   ///< iterations of the solve
  };
  std::vector<Step> steps;  ///< all solves in the order of the attempts

  /// True if the wanted problem was solved.
  bool ok() const { return reached == 1.0 && solution.ok(); }
};

/// Moves parameter `name` of the problem along the straight line between two values. The shooting
/// keeps the value of the last successful solve. Throws DefinitionError for unknown names and wrong
/// sizes.
Homotopy solve_along(MultipleShooting& shooting, Solver& solver, std::string_view name,
                     const VectorRef& from, const VectorRef& to,
                     const HomotopyOptions& options = {});

}  // namespace saltus
