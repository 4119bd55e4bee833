#include "saltus/solver/nonlinear_program.hpp"

#include "saltus/core/error.hpp"

namespace saltus {

void NonlinearProgram::prepare_derivatives(const double*, double, const double*, Curvature) {}

qp::StageStructure NonlinearProgram::stages() const {
  throw DefinitionError(
      "this program has no stages, so its quadratic programs cannot be solved stage by "
      "stage; use sparse_qp()");
}

}  // namespace saltus
