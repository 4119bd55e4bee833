// A quadratic program in stages as one sparse program that every solver can read.
//
// Variables in the order x_0, u_0, x_1, u_1, ..., rows in the order dynamics of stage 0, its
// groups, dynamics of stage 1, ...: what structured solvers expect to be told with `StageSizes`. A
// fixed start is a pair of equal bounds.
#pragma once

#include <vector>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// States, inputs and rows besides the dynamics.
struct StageSizes {
  int nx = 0, nu = 0, rows = 0;
};
std::vector<StageSizes> stage_sizes(const StageQp& qp);

/// Throws DefinitionError: the program has soft rows.
SparseQp flatten(const StageQp& qp);
/// The other way round, every stage with one group of rows. Throws DefinitionError: rows or costs
/// are not those of such stages.
StageQp in_stages(const SparseQp& flat, const std::vector<StageSizes>& sizes);
/// The same point, with the multipliers that make the same Lagrangian.
PrimalDualPoint flatten(const StageQp& qp, const StagePoint& point);

}  // namespace saltus::bench
