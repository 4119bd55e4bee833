// Newton's equations with a sparse factorisation.
#pragma once

#include <memory>

#include "saltus/core/sparsity.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus::qp {

/// The patterns are those of a SparseQp. The Hessian pattern must contain the whole diagonal.
std::unique_ptr<NewtonSystem> make_sparse_newton(const SparsityPattern& hessian,
                                                 const SparsityPattern& rows);

}  // namespace saltus::qp
