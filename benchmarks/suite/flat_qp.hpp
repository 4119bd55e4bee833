// A quadratic program in stages as one sparse program for every solver.
//
// Variables in the order x_0, u_0, x_1, u_1, ..., rows in the order dynamics of stage 0, its
// groups, dynamics of stage 1, ...: the order that structured solvers expect, with `StageSizes`. A
// fixed start is a pair of equal bounds.
#pragma once

#include <vector>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// Numbers of states, inputs and rows besides the dynamics.
struct StageSizes {
  int nx = 0, nu = 0, rows = 0;
};
std::vector<StageSizes> stage_sizes(const qp::StageQp& qp);

/// Throws DefinitionError if the program has soft rows.
qp::SparseQp flatten(const qp::StageQp& qp);
/// The inverse, with one group of rows per stage. Throws DefinitionError if rows or costs do not
/// fit into such stages.
qp::StageQp in_stages(const qp::SparseQp& flat, const std::vector<StageSizes>& sizes);
/// Converts a point, with the multipliers of the same Lagrangian.
PrimalDualPoint flatten(const qp::StageQp& qp, const qp::StagePoint& point);
/// The inverse. A fixed start has no multiplier.
qp::StagePoint in_stages(const qp::StageQp& qp, const PrimalDualPoint& flat);
/// The variables with their states replaced by a roll-out of the inputs.
VectorXd rolled_out(const qp::StageQp& qp, const VectorXd& variables);

}  // namespace saltus::bench
