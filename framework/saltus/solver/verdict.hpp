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

/// Replaces `unbounded` by a numerical failure unless the cost of the result is below that of the
/// start: iterates that diverge do not show that the cost does.
SolveStatus status_by_descent(SolveStatus status, NonlinearProgram& program, const VectorXd& start,
                              double cost);

}  // namespace saltus
