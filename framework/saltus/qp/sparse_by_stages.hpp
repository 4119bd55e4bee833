// A solver of programs in stages as a solver of sparse ones whose stages are known.
#pragma once

#include <functional>
#include <memory>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp_solver.hpp"
#include "saltus/qp/stage_structure.hpp"

namespace saltus {

/// Makes a stage solver for programs within the capacity of the one given.
using MakeStageSolver = std::function<std::unique_ptr<StageQpSolver>(const StageQp&)>;

/// For programs with the patterns of `patterns`. Throws DefinitionError if the structure does not
/// fit them, naming what does not. Numbers that cannot be staged (see StageFill) are an
/// invalid_problem. Residual and violation of a result are those of the program in stages.
std::unique_ptr<QpSolver> make_sparse_solver_by_stages(const SparseQp& patterns,
                                                       StageStructure structure,
                                                       const MakeStageSolver& make);

}  // namespace saltus
