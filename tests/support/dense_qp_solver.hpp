// A slow, dense solver of quadratic programs behind the QpSolver seam: for tests of what stands on
// that seam, independent of the solvers of saltus/qp.
#pragma once

#include <memory>

#include "saltus/qp/sparse_qp.hpp"

namespace saltus::testing_support {

/// Mehrotra's predictor-corrector with an LU of the whole system. Non-convex programs end anywhere.
std::unique_ptr<QpSolver> make_dense_qp_solver(const SparsityPattern& hessian,
                                               const SparsityPattern& rows,
                                               const QpOptions& options);

}  // namespace saltus::testing_support
