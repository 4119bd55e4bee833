// Newton's equations stage by stage: a Riccati recursion in place of a sparse factor.
#pragma once

#include <memory>
#include <span>

#include "saltus/qp/newton_system.hpp"
#include "saltus/qp/stage_structure.hpp"

namespace saltus {

namespace qp {
struct RiccatiKernel;
}

/// Throws DefinitionError if the structure does not fit the patterns. The Hessian's pattern needs
/// the whole diagonal. `kernels` as for make_riccati_solver().
std::unique_ptr<NewtonSystem> make_riccati_newton(const SparsityPattern& hessian,
                                                  const SparsityPattern& rows,
                                                  StageStructure structure,
                                                  std::span<const qp::RiccatiKernel> kernels = {});

}  // namespace saltus
