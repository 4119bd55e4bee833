// Is a plan what it claims to be? Recomputed from the definition of the problem and the plan alone,
// by integrators, quadratures and searches that no solver or transcription shares.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/verify/accuracy.hpp"
#include "saltus/verify/plan.hpp"
#include "saltus/verify/verification.hpp"

namespace saltus {

/// What was found in one interval of a plan.
struct IntervalFinding {
  double violation = 0.0;  ///< largest between the nodes, in the units of its term
  double excess = 0.0;     ///< the largest as a multiple of its tolerance
  double defect = 0.0;     ///< of the integration, relative (VerifiedDefect)
};

/// A path constraint that is violated between the nodes.
struct PathFinding {
  VerifiedMiss miss;  ///< where it is worst, relative to its tolerance
  /// What changes the term much, in its units: its range along the phase or, where that is more,
  /// what nominal changes of state and input do to it there.
  double scale = 1.0;
};

/// A verification with what each interval contributes.
struct VerificationDetail {
  Verification summary;                    ///< what Solution carries
  std::vector<IntervalFinding> intervals;  ///< of each interval of the plan
  std::vector<PathFinding> violated;       ///< the largest multiple of its tolerance first
};

/// How a plan is verified.
struct VerifyOptions {
  GridAccuracy accuracy = {};    ///< tolerances
  double resolution = infinity;  ///< violations below it need not be found, in units of the term
};

/// Verifies a plan. The problem must have the data that the plan was made for
/// (present_problem()). Allocates; takes about as long as a few evaluations of the program.
VerificationDetail verify(const OptimalControlProblem& problem, const Plan& plan,
                          const VerifyOptions& options = {});

}  // namespace saltus
