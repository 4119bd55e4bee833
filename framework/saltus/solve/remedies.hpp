// Finds remedies: changes of numbers of a problem that make it feasible.
#pragma once

#include <vector>

#include "saltus/solve/least_relaxation.hpp"
#include "saltus/solve/solve_budget.hpp"

namespace saltus {

/// Returns at most `most` changes of one number each, least effort first, and then the shortages
/// themselves. The multipliers give the rate at which the relaxation decreases with a number. Each
/// change is made and the changed problem solved; changes that fail are not reported.
std::vector<Explanation::Remedy> find_remedies(const OptimalControlProblem& problem,
                                               LeastRelaxation& relaxed,
                                               const RelaxedConstraints& gives, int most,
                                               SolveBudget& solves);

}  // namespace saltus
