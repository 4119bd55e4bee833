// What would help: which numbers of a problem could move so that nothing has to give.
#pragma once

#include <vector>

#include "saltus/solve/counted_solves.hpp"
#include "saltus/solve/least_relaxation.hpp"

namespace saltus {

/// At most `most` changes of one number each, the least effort first, and behind them what gives
/// itself. How fast the relaxation falls with a number is read from its multipliers; the change is
/// then made, and the problem with it solved: what does not work is not told.
std::vector<Remedy> find_remedies(const OptimalControlProblem& problem, LeastRelaxation& relaxed,
                                  const WhatGives& gives, int most, CountedSolves& solves);

}  // namespace saltus
