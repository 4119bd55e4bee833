// The interior-point method on a sparse factor: for programs that do not fall into stages, and to
// cross-check the solver of those that do.
#pragma once

#include <memory>

#include "saltus/qp/sparse_qp.hpp"

namespace saltus {

/// For programs with these patterns (of the Hessian the lower triangle). Programs with others, and
/// data that are no problem, get the status invalid_problem.
std::unique_ptr<QpSolver> make_sparse_qp_solver(const SparsityPattern& hessian,
                                                const SparsityPattern& rows,
                                                const QpOptions& options = {});

}  // namespace saltus
