// Refinement of a grid until the plan keeps its path constraints between the nodes, where their
// rows do not look, and the integration is accurate.
#pragma once

#include <string>
#include <vector>

#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

/// How intervals are cut where a plan breaks constraints between nodes.
struct RefinementOptions {
  double tolerance = 1e-6;    ///< on the largest violation between nodes, in the term's units
  double integration = 1e-3;  ///< on VerifiedDefect::sum
  /// The intervals of inputs stay as they are, and new nodes in them only let their rows look
  /// (Mesh::holds): for a plan that is carried out at the rate of the first grid.
  bool hold_inputs = false;
  int rounds = 12;            ///< solves, the first included
  int most_intervals = 2000;  ///< per phase
};

/// What a solve with refinement gave.
struct RefinedSolution {
  MultipleShooting shooting;  ///< the last one that was solved
  Solution solution;          ///< of it
  /// Per phase; where they lie: shooting.options().meshes.
  std::vector<int> intervals = {};
  /// After each solve, the largest violation between nodes.
  std::vector<double> violations = {};
  int iterations = 0;        ///< of all solves
  double seconds = 0.0;      ///< of all solves, wall clock
  bool reached = false;      ///< solution.ok(), and within the tolerances
  std::string message = {};  ///< one sentence: what was reached, or what ended it
};

/// Solves, measures between the nodes and the error of the integration, and cuts the intervals that
/// miss a tolerance into two to four, so that old nodes stay nodes and no others come where all is
/// well; each solve begins with the trajectory before. While an obstacle is passed between two
/// nodes, inputs are held through the new ones, or the plan would pass the next finer interval:
/// what is reached is then an optimum for inputs on the intervals before. Ends when the tolerances
/// are met by a plan that is ok(), a limit is reached or a solve fails, which leaves the last
/// successful one.
RefinedSolution solve_refined(const OptimalControlProblem& problem, ShootingOptions options,
                              Solver& solver, const RefinementOptions& refinement = {});

}  // namespace saltus
