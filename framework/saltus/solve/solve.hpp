// One call from a problem to its solution: a grid, an integrator and a solver are chosen unless you
// say which.
//
//     const Solution plan = solve(car);
//     const Solution finer = solve(car, {.intervals_per_phase = 100,
//                                        .integrator = cvodes({.tolerance = 1e-9}),
//                                        .solver = make_ipopt()});
//
// For many solves of one problem with other data, keep a MultipleShooting and a Solver.
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

/// How a problem is transcribed and solved.
struct SolveOptions {
  int intervals_per_phase = 30;     ///< of every phase
  std::vector<int> intervals = {};  ///< per phase, in place of the number above
  /// Empty: runge_kutta4({.steps = 2}). For stiff dynamics take one of SUNDIALS.
  IntegratorChoice integrator = {};
  int threads = 1;  ///< that evaluate intervals: ShootingOptions::threads
  /// Empty: make_sqp(), our own, to a scaled KKT error of 1e-8. A solver may be used again.
  std::shared_ptr<Solver> solver = {};
  /// Where the search starts, in place of the problem's own guess: another solution of it, on any
  /// grid.
  std::optional<Trajectory> guess = {};
  /// Hears of every iteration, and may end the solve: solver/observer.hpp.
  SolveObserver observer = {};
};

/// A solve that does not converge is a result: see Solution::status and message. Throws
/// DefinitionError when the problem or the options are wrong.
Solution solve(const OptimalControlProblem& problem, const SolveOptions& options = {});
/// Refused by the compiler in one sentence.
template <std::same_as<ShootingOptions> Options>
Solution solve(const OptimalControlProblem& problem, const Options&) {
  static_assert(!std::same_as<Options, ShootingOptions>,
                "solve(problem, options) takes SolveOptions; ShootingOptions are those of "
                "MultipleShooting(problem, options)");
  return solve(problem);
}

}  // namespace saltus
