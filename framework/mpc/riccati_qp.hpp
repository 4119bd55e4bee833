// The structured solver for the quadratic programs of a transcription.
#pragma once

#include <span>

#include "saltus/qp/riccati_solver.hpp"
#include "saltus/solver/sqp.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// Solves in the stages of `shooting`, whose nlp() the programs must be models of. Tolerance and
/// limit of iterations come from whom the solver is made for, everything else from `options`.
QpSolverFactory riccati_qp_solver(const MultipleShooting& shooting, RiccatiOptions options = {},
                                  std::span<const qp::RiccatiKernel> kernels = {});

}  // namespace saltus
