#include "saltus/model/make_function.hpp"

#include "saltus/autodiff/formula_steps.hpp"

namespace saltus::detail {

TracedBody::TracedBody(int inputs, int outputs) : FunctionBody(inputs, outputs) {}

TracedBody::~TracedBody() = default;

void TracedBody::find_structure(const FormulaName& name, const Arguments& sizes, int jacobian_lanes,
                                int hessian_lanes) {
  const FormulaStructure structure =
      traced_structure(name, sizes, outputs(), [this](const Tracer* z, Tracer* y) { trace(z, y); });
  jacobian_pattern_ = structure.jacobian;
  hessian_pattern_ = structure.hessian;
  jacobian_passes_ = jacobian_passes(jacobian_pattern_, jacobian_lanes);
  hessian_passes_ = hessian_passes(hessian_pattern_, hessian_lanes);
}

int TracedBody::degree(int output, const std::vector<char>& variable) const {
  return traced(variable)[output].degree();
}

std::vector<Tracer> TracedBody::traced(const std::vector<char>& variable) const {
  std::vector<Tracer> z, y(outputs());
  for (int i = 0; i < inputs(); ++i) z.push_back(Tracer::input(i, variable[i] ? 1 : 0));
  trace(z.data(), y.data());
  if (StepRecorder* recorder = StepRecorder::active()) {
    recorder->end(z, y, static_cast<const FunctionBody*>(this));
  }
  return y;
}

}  // namespace saltus::detail
