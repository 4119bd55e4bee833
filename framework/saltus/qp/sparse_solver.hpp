// The interior-point method with a sparse factorisation: for programs without stages, and to
// cross-check the stage solver.
#pragma once

#include <memory>

#include "saltus/qp/sparse_qp.hpp"

namespace saltus {

/// `hessian` is the lower triangle. Programs with other patterns and invalid data get the status
/// invalid_problem.
std::unique_ptr<QpSolver> make_sparse_qp_solver(const SparsityPattern& hessian,
                                                const SparsityPattern& rows,
                                                const QpOptions& options = {});

}  // namespace saltus
