// Computes and evaluates the least relaxation of a problem.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "saltus/solve/explain.hpp"
#include "saltus/solve/negotiable_constraints.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// Smallest relaxation that counts: the accuracy of a good solution of the problem itself.
inline constexpr double smallest_relaxation = 1e-6;

/// Total multipliers of a constraint at the optimum.
struct HoldingForce {
  double upper = 0.0, lower = 0.0;  ///< sums over upper and lower sides, positive
  bool is_value = true;             ///< both sides are equal at all nodes
};

/// Result of the elastic program of a problem.
struct LeastRelaxation {
  std::unique_ptr<MultipleShooting> shooting;  ///< transcription of the problem
  std::vector<NegotiableConstraint> asked;     ///< its negotiable constraints
  std::vector<int> group;  ///< group in `program` of each entry of `asked`; -1: hard
  std::unique_ptr<ElasticProgram> program;  ///< relaxed program of `shooting`
  NlpResult result;                         ///< solution of `program`
  double amount = infinity;                 ///< sum of the amounts divided by nominal values

  /// True if the relaxation is a local minimum.
  bool ok() const { return is_success(result.status); }
  /// True if the problem needs a relaxation.
  bool is_needed() const { return amount > smallest_relaxation; }
  /// The solution as a point of the original program.
  VectorXd point() const;
  /// The trajectory of the solution.
  Trajectory trajectory() const;
  /// Multiplier of a row of `program`.
  double multiplier(int row) const { return result.point.lambda[row]; }
  /// Total multipliers of asked[k].
  HoldingForce force_of(int k) const;
};

/// Solves the elastic program from the trajectory, or by default from the problem's own guess.
/// Throws DefinitionError for invalid problems or options.
LeastRelaxation least_relaxation(
    const OptimalControlProblem& problem, const ShootingOptions& options, Solver& solver,
    const Trajectory* guess = nullptr,
    const std::function<bool(const NegotiableConstraint&)>& is_negotiable = {});

/// Relaxed constraints of a least relaxation.
struct RelaxedConstraints {
  std::vector<Explanation::Shortage> shortages;  ///< largest first, relative to nominal values
  std::vector<ProblemChange> changes;            ///< moves of bounds that make the problem feasible
  bool can_change = true;  ///< `changes` covers all shortages: a closing cannot change
};
/// Collects the relaxed constraints. Rows that repeat each other, as in hulls of fixed size, are
/// listed once.
RelaxedConstraints relaxed_constraints(LeastRelaxation& relaxed);

}  // namespace saltus
