// The cost of a plan by the definition of the problem, and all its rows at single instants.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/verify/verification.hpp"
#include "saltus/verify/verify.hpp"

namespace saltus {

/// Integrals of a phase from its start to its end, by the verifier's quadrature.
struct PhaseTotals {
  std::vector<double> costs;      ///< per term of the phase; 0 if it is not an integrated cost
  std::vector<double> integrals;  ///< per integral constraint
};

/// A cost, and the sum of the magnitudes of its contributions.
struct PlanCost {
  double value = 0.0, magnitude = 0.0;
};
/// Costs, and penalties of soft terms for the violations of the plan.
PlanCost cost_of(const OptimalControlProblem& problem, const Plan& plan,
                 const std::vector<PhaseTotals>& totals);

/// Receives every violated row with its tolerance.
using NoteMiss = std::function<void(Verification::Miss)>;
/// Checks hard rows at ends of phases with this end state instead of the planned one; empty: the
/// planned one.
void check_end_terms(const OptimalControlProblem& problem, const Plan& plan, int phase,
                     const VectorXd& end_state, const GridAccuracy& accuracy, const NoteMiss& note);
/// Checks start, jumps, closing, links, integrals, durations, unknowns and input bounds.
void check_instants(const OptimalControlProblem& problem, const Plan& plan,
                    const std::vector<PhaseTotals>& totals, const GridAccuracy& accuracy,
                    const NoteMiss& note);

/// z = (t | x | u | p) of a phase with the input of an interval at its start or end.
VectorXd argument_of(const Arguments& sizes, const Plan::Interval& interval, bool at_end,
                     const VectorXd& parameters);

}  // namespace saltus
