// A slow, dense solver of quadratic programs behind the qp::QpSolver interface. Tests of code
// behind this interface use it, because it is independent of the solvers of saltus/qp.
#pragma once

#include <memory>

#include "saltus/qp/sparse_qp.hpp"

namespace saltus::testing_support {

/// Mehrotra's predictor-corrector method with an LU of the whole system. The result for a non-
/// convex program is arbitrary.
std::unique_ptr<qp::QpSolver> make_dense_qp_solver(const SparsityPattern& hessian,
                                                   const SparsityPattern& rows,
                                                   const qp::QpOptions& options);

}  // namespace saltus::testing_support
