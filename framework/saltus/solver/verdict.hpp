// The status of a solve, judged by the residual that it reports.
#pragma once

#include "saltus/solver/solver.hpp"

namespace saltus {

/// Largest reported residual, as a multiple of the tolerance, that counts as success.
inline constexpr double acceptable_multiple = 100.0;

/// The status that the residual allows. Solvers end by the error in a scale of their own.
/// `otherwise` replaces a success whose reported residual is larger than acceptable_multiple times
/// the tolerance.
SolveStatus status_by_residual(SolveStatus status, const KktResidual& kkt, double tolerance,
                               SolveStatus otherwise);

}  // namespace saltus
