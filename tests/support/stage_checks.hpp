// Is a program in stages the sparse program that it was made from? Checks that need no solver, and
// checks of a solution that is carried there and back.
#pragma once

#include <random>

#include "saltus/qp/stage_map.hpp"

namespace saltus::testing_support {

double uniform(std::mt19937& random, double low, double high);

/// Random inputs within their bounds, and the states to which they lead.
StagePoint random_trajectory(const StageQp& qp, std::mt19937& random);

/// Costs agree, and so does what is violated: the dynamics hold in both.
void expect_equivalent(const SparseQp& qp, StageMap& map, std::mt19937& random);

/// The optimum of the stages is an optimum of the sparse program, with multipliers, and back.
void expect_same_optimum(const SparseQp& qp, StageMap& map);

/// The active parts are equal, number by number.
void expect_equal(const StageQp& a, const StageQp& b);

}  // namespace saltus::testing_support
