// Finds remedies: changes of numbers of a problem that make it feasible.
#pragma once

#include <vector>

#include "saltus/solve/counted_solves.hpp"
#include "saltus/solve/least_relaxation.hpp"

namespace saltus {

/// Returns at most `most` changes of one number each, least effort first, and then the shortages
/// themselves. The multipliers give the rate at which the relaxation decreases with a number. Each
/// change is made and the changed problem solved; changes that fail are not reported.
std::vector<Remedy> find_remedies(const OptimalControlProblem& problem, LeastRelaxation& relaxed,
                                  const WhatGives& gives, int most, CountedSolves& solves);

}  // namespace saltus
