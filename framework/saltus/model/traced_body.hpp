// Common base of the bodies of all formulas: traced patterns and the passes that fill them.
// Compiled once, not with every formula.
#pragma once

#include <vector>

#include "saltus/autodiff/tracer.hpp"
#include "saltus/model/function.hpp"
#include "saltus/model/seeding.hpp"
#include "saltus/model/trace_formula.hpp"

namespace saltus::detail {

class TracedBody : public FunctionBody {
 public:
  ~TracedBody() override;
  int degree(int output, const std::vector<char>& variable) const override;
  bool is_reentrant() const override { return true; }

 protected:
  TracedBody(int inputs, int outputs);
  /// Finds patterns and passes. Call it at the end of the derived constructor. Throws
  /// DefinitionError with the formula, see traced_structure().
  void find_structure(const FormulaName& name, const Arguments& sizes, int jacobian_lanes,
                      int hessian_lanes);
  /// Computes y = formula(z) with inputs() and outputs() entries.
  virtual void trace(const Tracer* z, Tracer* y) const = 0;

  std::vector<JacobianPass> jacobian_passes_;
  std::vector<HessianPass> hessian_passes_;

 private:
  std::vector<Tracer> traced(const std::vector<char>& variable) const;
};

}  // namespace saltus::detail
