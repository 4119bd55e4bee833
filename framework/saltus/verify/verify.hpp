// Verifies a plan from the definition of the problem and the plan alone. The integrators,
// quadratures and searches are independent of all solvers and transcriptions.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/verify/verification.hpp"

namespace saltus {

// A plan as input of the verifier: numbers only, independent of the transcription.

/// States and inputs of all phases, and the reported cost.
struct Plan {
  /// One interval of a plan, between two nodes.
  struct Interval {
    int phase = 0;          ///< index of the phase
    double start = 0.0;     ///< absolute time in seconds
    double length = 0.0;    ///< length in seconds
    VectorXd state;         ///< state at the start
    VectorXd coefficients;  ///< coefficients of the input: nu numbers, or 2 nu for linear inputs
    VectorXd end_state;     ///< state at the end, before a jump

    /// Absolute time of the end in seconds.
    double end() const { return start + length; }
  };

  std::vector<Interval> intervals;   ///< intervals in order of time
  std::vector<VectorXd> parameters;  ///< p of each phase, including unknowns
  std::vector<double> starts;        ///< start of each phase, in seconds
  std::vector<double> durations;     ///< duration of each phase, in seconds
  double cost = 0.0;                 ///< as reported
  /// Part of `cost` that depends on the grid as well as on the problem (penalise_change).
  double grid_cost = 0.0;
};

/// A verification with the results of each interval.
struct VerificationDetail {
  /// Result for one interval of a plan.
  struct Interval {
    double violation = 0.0;  ///< largest between the nodes, in the units of its term
    double excess = 0.0;     ///< largest multiple of a tolerance
    double defect = 0.0;     ///< integration error, relative (Verification::Defect)
  };

  /// A path constraint that is violated between the nodes.
  struct Path {
    Verification::Miss miss;  ///< largest violation relative to its tolerance
    /// Scale of the term in its units: the larger of its range along the phase and its change by
    /// nominal changes of state and input.
    double scale = 1.0;
  };

  Verification summary;             ///< result as in Solution
  std::vector<Interval> intervals;  ///< one per interval of the plan
  std::vector<Path> violated;       ///< largest multiple of its tolerance first
};

/// Options of verify().
struct VerifyOptions {
  GridAccuracy accuracy = {};    ///< tolerances
  double resolution = infinity;  ///< smaller violations may be missed, in units of the term
};

/// Verifies a plan. The problem must have the data of the plan (current_problem()). Allocates;
/// takes about as long as a few evaluations of the program.
VerificationDetail verify(const OptimalControlProblem& problem, const Plan& plan,
                          const VerifyOptions& options = {});

}  // namespace saltus
