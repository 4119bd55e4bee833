// Do path constraints hold between the nodes? Their rows stand at nodes only: inside an interval
// the trajectory follows the dynamics and may bulge out. And refinement until it does so little.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

/// Points looked at inside each interval. The top of a bulge falls between two of them; by a
/// parabola at most 1/400 of it is missed.
inline constexpr int samples_between_nodes = 20;

/// The largest violation of each hard path constraint (keep(), bound_state()) inside the intervals
/// where it is in force, along the dense output; only what is violated is listed, the largest
/// first. Infinite where the trajectory or the formula cannot be evaluated. Bounds on inputs hold
/// wherever they hold at the ends, inputs being constant or linear in between. Allocates.
std::vector<PathViolation> violations_between_nodes(const MultipleShooting& shooting,
                                                    const Trajectory& trajectory,
                                                    int samples = samples_between_nodes);

struct RefinementOptions {
  double tolerance = 1e-6;    ///< on the largest violation between nodes, in the term's units
  int rounds = 8;             ///< solves, the first included
  int most_intervals = 2000;  ///< per phase
};

struct RefinedSolution {
  MultipleShooting shooting;   ///< the last one that was solved
  Solution solution;           ///< of it
  std::vector<int> intervals;  ///< per phase
  /// After each solve, the largest violation between nodes.
  std::vector<double> violations;
  bool reached = false;  ///< solved, and within the tolerance
  std::string message;   ///< one sentence: what was reached, or what ended it
};

/// Makes the solver of one grid; called anew for each.
using SolverFactory = std::function<std::unique_ptr<Solver>(const MultipleShooting&)>;

/// Solves, measures between the nodes and raises the number of intervals of the phases that miss
/// the tolerance, two to four times, so that old nodes stay nodes; each solve begins with the
/// trajectory before. Ends when the tolerance is met, a limit is reached or a solve fails, which
/// leaves the last successful one.
RefinedSolution solve_refined(const OptimalControlProblem& problem, ShootingOptions options,
                              const SolverFactory& make_solver,
                              const RefinementOptions& refinement = {});

}  // namespace saltus
