// Status of a solve, judged by its reported residual.
#pragma once

#include "saltus/solver/solver.hpp"

namespace saltus {

/// Largest reported residual, as a multiple of the tolerance, that counts as success.
inline constexpr double acceptable_multiple = 100.0;

/// Status that the residual permits. Solvers terminate by the error in their own scaling.
/// `otherwise` replaces a success whose reported residual exceeds acceptable_multiple times the
/// tolerance.
SolveStatus status_by_residual(SolveStatus status, const KktCheck::Residual& kkt, double tolerance,
                               SolveStatus otherwise);

}  // namespace saltus
