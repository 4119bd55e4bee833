// Newton's equations solved stage by stage: a Riccati recursion instead of a sparse factorisation.
#pragma once

#include <memory>
#include <span>

#include "saltus/qp/qp_result.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus::qp {

struct RiccatiKernel;

/// Throws DefinitionError if the structure does not fit the patterns. The Hessian pattern must
/// contain the whole diagonal. For `kernels` see make_riccati_solver().
std::unique_ptr<NewtonSystem> make_riccati_newton(const SparsityPattern& hessian,
                                                  const SparsityPattern& rows,
                                                  StageStructure structure,
                                                  std::span<const RiccatiKernel> kernels = {});

}  // namespace saltus::qp
