// Verifies a plan from the definition of the problem and the plan alone. The integrators,
// quadratures and searches are independent of all solvers and transcriptions.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/verify/accuracy.hpp"
#include "saltus/verify/plan.hpp"
#include "saltus/verify/verification.hpp"

namespace saltus {

/// Result for one interval of a plan.
struct IntervalFinding {
  double violation = 0.0;  ///< largest between the nodes, in the units of its term
  double excess = 0.0;     ///< largest multiple of a tolerance
  double defect = 0.0;     ///< of the integration, relative (VerifiedDefect)
};

/// A path constraint that is violated between the nodes.
struct PathFinding {
  VerifiedMiss miss;  ///< largest violation relative to its tolerance
  /// Scale of the term in its units: the larger of its range along the phase and its change by
  /// nominal changes of state and input.
  double scale = 1.0;
};

/// A verification with the results of each interval.
struct VerificationDetail {
  Verification summary;                    ///< as in Solution
  std::vector<IntervalFinding> intervals;  ///< one per interval of the plan
  std::vector<PathFinding> violated;       ///< largest multiple of its tolerance first
};

/// Options of verify().
struct VerifyOptions {
  GridAccuracy accuracy = {};    ///< tolerances
  double resolution = infinity;  ///< smaller violations may be missed, in units of the term
};

/// Verifies a plan. The problem must have the data of the plan (present_problem()). Allocates;
/// takes about as long as a few evaluations of the program.
VerificationDetail verify(const OptimalControlProblem& problem, const Plan& plan,
                          const VerifyOptions& options = {});

}  // namespace saltus
