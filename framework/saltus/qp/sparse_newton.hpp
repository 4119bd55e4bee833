// Newton's equations on a sparse factor.
#pragma once

#include <memory>

#include "saltus/core/sparsity.hpp"
#include "saltus/qp/newton_system.hpp"

namespace saltus {

/// Patterns as in SparseQp; the Hessian's needs the whole diagonal.
std::unique_ptr<NewtonSystem> make_sparse_newton(const SparsityPattern& hessian,
                                                 const SparsityPattern& rows);

}  // namespace saltus
