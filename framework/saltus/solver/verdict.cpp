#include "saltus/solver/verdict.hpp"

namespace saltus {

SolveStatus status_by_residual(SolveStatus status, const KktCheck::Residual& kkt, double tolerance,
                               SolveStatus otherwise) {
  if (status != SolveStatus::optimal && status != SolveStatus::acceptable) return status;
  const double residual = kkt.scaled();
  if (residual <= tolerance) return SolveStatus::optimal;
  return residual <= acceptable_multiple * tolerance ? SolveStatus::acceptable : otherwise;
}

SolveStatus status_by_descent(SolveStatus status, NonlinearProgram& program, const VectorXd& start,
                              double cost) {
  double first = 0.0;
  if (status != SolveStatus::unbounded || start.size() != program.variables() ||
      !program.objective(start.data(), first) || cost < first)
    return status;
  return SolveStatus::numerical_failure;
}

}  // namespace saltus
