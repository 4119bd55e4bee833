// Soft terms that give way at an optimum, and why: they cannot hold, or that would cost more.
#pragma once

#include "saltus/solve/counted_solves.hpp"
#include "saltus/solve/explanation.hpp"

namespace saltus {

/// Rows of soft terms, links and integrals that give way in a solution of the shooting, the dearest
/// first; those that hardly cost anything beside them are left out.
std::vector<SoftShortage> soft_shortages(MultipleShooting& shooting, const Solution& solution);

/// The problem in which they are hard, with all rows of their terms.
OptimalControlProblem with_held(const OptimalControlProblem& problem,
                                const std::vector<SoftShortage>& soft);

/// Solves the problem, whose hard terms can be met, and completes the explanation: what gives way,
/// and at most so many remedies.
void explain_soft_terms(const OptimalControlProblem& problem, int most_remedies,
                        CountedSolves& solves, Explanation& explanation);

}  // namespace saltus
