// Chooses how the derivatives of a formula are computed, by counted operations.
#include <memory>
#include <utility>

#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/core/workspace_pool.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/model/recorded_derivatives.hpp"

namespace saltus::detail {
namespace {

// A formula whose derivatives, or some of them, are computed from its recorded steps.
class RecordedBody final : public FunctionBody {
 public:
  using Parts = RecordedDerivatives::Parts;

  RecordedBody(std::shared_ptr<const FunctionBody> formula,
               std::shared_ptr<const RecordedDerivatives> recorded, Parts parts,
               Lending lending = Lending::shared)
      : FunctionBody(formula->inputs(), formula->outputs()),
        formula_(std::move(formula)),
        recorded_(std::move(recorded)),
        parts_(parts),
        workspaces_(lending) {
    jacobian_pattern_ = formula_->jacobian_pattern();
    hessian_pattern_ = formula_->hessian_pattern();
    workspaces_.add(new_workspace());
  }

  bool is_reentrant() const override { return workspaces_.is_shared(); }
  const FormulaSteps* steps() const override { return formula_->steps(); }
  int degree(int output, const std::vector<char>& variable) const override {
    return formula_->degree(output, variable);
  }
  std::shared_ptr<const FunctionBody> separate() const override {
    std::shared_ptr<const FunctionBody> own = formula_->separate();
    return std::make_shared<RecordedBody>(own ? own : formula_, recorded_, parts_,
                                          Lending::exclusive);
  }

  void value(const double* z, double* y) const override { formula_->value(z, y); }

  void jacobian(const double* z, double* y, double* entries) const override {
    if (!parts_.jacobian) return formula_->jacobian(z, y, entries);
    const auto workspace = lend();
    recorded_->jacobian(z, y, entries, *workspace);
  }

  void hessian(const double* z, const double* weights, double* entries,
               Curvature curvature) const override {
    if (!parts_.hessian) return formula_->hessian(z, weights, entries, curvature);
    const auto workspace = lend();
    recorded_->hessian(z, weights, entries, *workspace);
  }

  void derivatives(const double* z, const double* weights, double* y, double* jacobian_entries,
                   double* hessian_entries, Curvature curvature) const override {
    if (!parts_.jacobian || !parts_.hessian)
      return FunctionBody::derivatives(z, weights, y, jacobian_entries, hessian_entries, curvature);
    const auto workspace = lend();
    recorded_->derivatives(z, weights, y, jacobian_entries, hessian_entries, *workspace);
  }

 private:
  using Workspace = RecordedDerivatives::Workspace;

  std::unique_ptr<Workspace> new_workspace() const {
    return std::make_unique<Workspace>(recorded_->workspace());
  }
  WorkspacePool<Workspace>::Loan lend() const {
    return workspaces_.lend([this] { return new_workspace(); });
  }

  std::shared_ptr<const FunctionBody> formula_;
  std::shared_ptr<const RecordedDerivatives> recorded_;
  Parts parts_;
  WorkspacePool<Workspace> workspaces_;
};

// Fewer operations of dual numbers are not worth a workspace.
constexpr long fewest_operations = 2000;
// An operation of a recorded formula takes the time of one of dual numbers, but up to twice the
// instructions.
constexpr long least_gain = 2;

bool any(const RecordedDerivatives::Parts& parts) { return parts.jacobian || parts.hessian; }

}  // namespace

Function recorded_function(std::shared_ptr<const FunctionBody> formula) {
  const RecordedDerivatives::Parts all;
  const auto recorded = std::make_shared<const RecordedDerivatives>(
      *formula->steps(), formula->jacobian_pattern(), formula->hessian_pattern(), all);
  if (!recorded->is_complete()) return {};
  return Function(std::make_shared<const RecordedBody>(std::move(formula), recorded, all));
}

Function cheapest_function(std::unique_ptr<const TracedBody> body) {
  const std::shared_ptr<const TracedBody> formula = std::move(body);
  const long dual_jacobian = dual_operations(*formula->steps(), formula->jacobian_passes_.size());
  const long dual_hessian = dual_operations(*formula->steps(), formula->hessian_passes_.size());
  RecordedDerivatives::Parts parts{.jacobian = dual_jacobian >= fewest_operations,
                                   .hessian = dual_hessian >= fewest_operations};
  while (any(parts)) {
    const auto recorded = std::make_shared<const RecordedDerivatives>(
        *formula->steps(), formula->jacobian_pattern(), formula->hessian_pattern(), parts);
    if (!recorded->is_complete()) break;
    const RecordedDerivatives::Parts cheaper{
        .jacobian = parts.jacobian && least_gain * recorded->jacobian_operations() < dual_jacobian,
        .hessian = parts.hessian && least_gain * recorded->hessian_operations() < dual_hessian};
    if (cheaper == parts)
      return Function(std::make_shared<const RecordedBody>(formula, recorded, parts));
    parts = cheaper;
  }
  return Function(std::shared_ptr<const FunctionBody>(formula));
}

}  // namespace saltus::detail
