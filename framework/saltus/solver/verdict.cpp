#include "saltus/solver/verdict.hpp"

namespace saltus {

SolveStatus status_by_residual(SolveStatus status, const KktCheck::Residual& kkt, double tolerance,
                               SolveStatus otherwise) {
  if (status != SolveStatus::optimal && status != SolveStatus::acceptable) return status;
  const double residual = kkt.scaled();
  if (residual <= tolerance) return SolveStatus::optimal;
  return residual <= acceptable_multiple * tolerance ? SolveStatus::acceptable : otherwise;
}

}  // namespace saltus
