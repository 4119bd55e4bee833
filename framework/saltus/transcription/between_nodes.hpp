// Refines a grid until the plan satisfies its path constraints between the nodes and the
// integration is accurate.
#pragma once

#include <string>
#include <vector>

#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

/// Options of solve_refined().
struct RefinementOptions {
  double tolerance = 1e-6;    ///< tolerance of the violation between nodes, in the term's units
  double integration = 1e-3;  ///< tolerance of Verification::Defect::sum
  /// True keeps the input intervals: new nodes inside them only add constraint rows (Mesh::holds).
  /// Use it for a plan executed at the rate of the first grid.
  bool hold_inputs = false;
  int rounds = 12;            ///< maximum number of solves, including the first
  int most_intervals = 2000;  ///< per phase
};

/// Result of solve_refined().
struct RefinedSolution {
  MultipleShooting shooting;  ///< the last solved transcription
  Solution solution;          ///< its solution
  /// Intervals per phase. shooting.options().meshes has their positions.
  std::vector<int> intervals = {};
  /// Largest violation between nodes after each solve.
  std::vector<double> violations = {};
  int iterations = 0;        ///< total of all solves
  double seconds = 0.0;      ///< wall-clock time of all solves
  bool reached = false;      ///< solution.ok() and all tolerances met
  std::string message = {};  ///< one sentence: the achieved accuracy, or the reason for stopping
};

/// Solves and measures the violation between nodes and the integration error. Cuts intervals above
/// a tolerance into two to four, so that old nodes remain and accurate intervals stay as they are.
/// Each solve starts from the previous trajectory. If the path passes an obstacle between two
/// nodes, new nodes there hold the input. Otherwise the plan would pass it between the new nodes.
/// The result is then optimal for inputs on the coarser intervals. Stops when a plan is ok() and
/// within the tolerances, at a limit, or when a solve fails. After a failure, the result is the
/// last successful solve.
RefinedSolution solve_refined(const OptimalControlProblem& problem, ShootingOptions options,
                              Solver& solver, const RefinementOptions& refinement = {});

}  // namespace saltus
