// Checks that a program in stages is equivalent to the sparse program that it was made from. Some
// need no solver; others convert a solution in both directions.
#pragma once

#include <random>

#include "saltus/qp/stage_map.hpp"

namespace saltus::testing_support {

double uniform(std::mt19937& random, double low, double high);

/// Random inputs within their bounds, and the resulting states.
qp::StagePoint random_trajectory(const qp::StageQp& qp, std::mt19937& random);

/// Expects equal costs and equal violations in both forms. The dynamics hold in both.
void expect_equivalent(const qp::SparseQp& qp, qp::StageMap& map, std::mt19937& random);

/// Expects that an optimum of the stages is an optimum of the sparse program, with multipliers, and
/// the reverse.
void expect_same_optimum(const qp::SparseQp& qp, qp::StageMap& map);

/// Expects that the active parts are equal, number by number.
void expect_equal(const qp::StageQp& a, const qp::StageQp& b);

}  // namespace saltus::testing_support
