// Adapter that solves sparse programs with known stages by a stage solver.
#pragma once

#include <functional>
#include <memory>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp_solver.hpp"
#include "saltus/qp/stage_structure.hpp"

namespace saltus {

/// Makes a stage solver for programs within the given capacity.
using MakeStageSolver = std::function<std::unique_ptr<StageQpSolver>(const StageQp&)>;

/// For programs with the patterns of `patterns`. Throws DefinitionError if the structure does not
/// fit them and names the mismatch. Values that cannot be staged (see StageFill) give the status
/// invalid_problem. Residual and violation of a result refer to the program in stages.
std::unique_ptr<QpSolver> make_sparse_solver_by_stages(const SparseQp& patterns,
                                                       StageStructure structure,
                                                       const MakeStageSolver& make);

}  // namespace saltus
