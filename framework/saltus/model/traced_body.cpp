#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus::detail {

TracedBody::TracedBody(int inputs, int outputs) : FunctionBody(inputs, outputs) {}

TracedBody::~TracedBody() = default;

void TracedBody::find_structure(const FormulaName& name, const Arguments& sizes, int jacobian_lanes,
                                int hessian_lanes) {
  auto steps = std::make_unique<FormulaSteps>();
  const FormulaStructure structure = traced_structure(
      name, sizes, outputs(), [this](const Tracer* z, Tracer* y) { trace(z, y); }, *steps);
  jacobian_pattern_ = structure.jacobian;
  hessian_pattern_ = structure.hessian;
  jacobian_passes_ = jacobian_passes(jacobian_pattern_, jacobian_lanes);
  hessian_passes_ = hessian_passes(hessian_pattern_, hessian_lanes);
  steps_ = std::move(steps);
}

int TracedBody::degree(int output, const std::vector<char>& variable) const {
  return steps_->degree(output, variable);
}

}  // namespace saltus::detail
