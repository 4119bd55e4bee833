// Soft terms that are violated at an optimum, and the reason: they cannot hold, or holding them
// costs more.
#pragma once

#include "saltus/solve/explain.hpp"
#include "saltus/solve/solve_budget.hpp"

namespace saltus {

/// Rows of soft terms, links and integrals that are violated in a solution of the shooting, highest
/// price first. Rows with a negligible price are left out.
std::vector<Explanation::SoftShortage> soft_shortages(MultipleShooting& shooting,
                                                      const Solution& solution);

/// Returns the problem in which these terms are hard, with all their rows.
OptimalControlProblem with_hard_terms(const OptimalControlProblem& problem,
                                      const std::vector<Explanation::SoftShortage>& soft);

/// Solves the problem, whose hard terms are feasible, and completes the explanation with the
/// violated soft terms and at most `most_remedies` remedies.
void explain_soft_terms(const OptimalControlProblem& problem, int most_remedies,
                        SolveBudget& solves, Explanation& explanation);

}  // namespace saltus
