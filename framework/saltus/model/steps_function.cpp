// Evaluates a formula whose steps are known at run time only, one step after the other.
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "saltus/autodiff/apply_operation.hpp"
#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/core/workspace_pool.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/model/recorded_derivatives.hpp"
#include "saltus/model/steps_of.hpp"

namespace saltus {
namespace {

// Computes all steps. entry(i) is entry i of z.
template <class S, class Entry>
void evaluate(const FormulaSteps& formula, const Entry& entry, std::vector<S>& values) {
  static const S none(0.0);
  const auto at = [&](int step) -> const S& { return step < 0 ? none : values[step]; };
  for (std::size_t i = 0; i < formula.steps.size(); ++i) {
    const FormulaStep& step = formula.steps[i];
    if (step.operation == Operation::input)
      values[i] = S(entry(static_cast<int>(step.value)));
    else if (step.operation == Operation::constant)
      values[i] = S(step.value);
    else if (step.operation == Operation::pow &&
             formula.steps[step.b].operation == Operation::constant)
      values[i] = S(pow(at(step.a), formula.steps[step.b].value));
    else
      values[i] = detail::apply(step.operation, at(step.a), at(step.b), at(step.c));
  }
}

class StepsBody final : public detail::TracedBody {
  static constexpr int jacobian_lanes = native_lanes;
  static constexpr int hessian_lanes = std::min(native_lanes, 4);
  using First = Dual<double, jacobian_lanes>;
  using Second = Dual<Dual<double, hessian_lanes>, 1>;
  struct Workspace {
    std::vector<double> values;
    std::vector<First> first;
    std::vector<Second> second;
  };

 public:
  // `differentiates` is false if another body computes the derivatives.
  StepsBody(std::shared_ptr<const FormulaSteps> formula, const FormulaName& name,
            bool differentiates, detail::Lending lending = detail::Lending::shared)
      : TracedBody(formula->inputs, static_cast<int>(formula->outputs.size())),
        formula_(std::move(formula)),
        differentiates_(differentiates),
        workspaces_(lending) {
    find_structure(name, {formula_->inputs - 1, 0, 0}, jacobian_lanes, hessian_lanes);
    workspaces_.add(new_workspace());
  }

  bool is_reentrant() const override { return workspaces_.is_shared(); }
  std::shared_ptr<const FunctionBody> separate() const override {
    return std::make_shared<StepsBody>(formula_, FormulaName{}, differentiates_,
                                       detail::Lending::exclusive);
  }

  void value(const double* z, double* y) const override {
    const auto workspace = lend();
    std::vector<double>& values = workspace->values;
    evaluate(
        *formula_, [z](int i) { return z[i]; }, values);
    for (int r = 0; r < outputs(); ++r) y[r] = values[formula_->outputs[r]];
  }

  void jacobian(const double* z, double* y, double* entries) const override {
    if (jacobian_passes_.empty()) return value(z, y);
    const auto workspace = lend();
    std::vector<First>& values = workspace->first;
    for (const detail::JacobianPass& pass : jacobian_passes_) {
      const double* tangents = pass.tangents.data();
      evaluate(
          *formula_,
          [=](int i) { return First(z[i], First::Tangent::load(tangents + i * jacobian_lanes)); },
          values);
      for (const detail::Reading& r : pass.readings)
        entries[r.entry] = values[formula_->outputs[r.row]].tangent[r.lane];
    }
    for (int r = 0; r < outputs(); ++r) y[r] = values[formula_->outputs[r]].value;
  }

  void hessian(const double* z, const double* weights, double* entries, Curvature) const override {
    if (hessian_passes_.empty()) return;
    using Inner = decltype(Second::value);
    const auto workspace = lend();
    std::vector<Second>& values = workspace->second;
    for (const detail::HessianPass& pass : hessian_passes_) {
      const double* tangents = pass.tangents.data();
      const double* outer = pass.outer_tangents.data();
      evaluate(
          *formula_,
          [=](int i) {
            return Second(Inner(z[i], Inner::Tangent::load(tangents + i * hessian_lanes)),
                          {{Inner(outer[i])}});
          },
          values);
      const auto tangent = [&](int r) { return values[formula_->outputs[r]].tangent[0].tangent; };
      auto sum = weights[0] * tangent(0);
      for (int r = 1; r < outputs(); ++r) sum += weights[r] * tangent(r);
      for (const detail::Reading& r : pass.readings) entries[r.entry] = sum[r.lane];
    }
  }

 private:
  void trace(const Tracer* z, Tracer* y) const override {
    std::vector<Tracer> values(formula_->steps.size());
    evaluate(
        *formula_, [z](int i) { return z[i]; }, values);
    for (int r = 0; r < outputs(); ++r) y[r] = values[formula_->outputs[r]];
  }
  std::unique_ptr<Workspace> new_workspace() const {
    auto workspace = std::make_unique<Workspace>();
    workspace->values.resize(formula_->steps.size());
    if (differentiates_) {
      workspace->first.resize(formula_->steps.size());
      workspace->second.resize(formula_->steps.size());
    }
    return workspace;
  }
  detail::WorkspacePool<Workspace>::Loan lend() const {
    return workspaces_.lend([this] { return new_workspace(); });
  }

  std::shared_ptr<const FormulaSteps> formula_;
  bool differentiates_;
  detail::WorkspacePool<Workspace> workspaces_;
};

}  // namespace

Function function_of(FormulaSteps steps, const FormulaName& name) {
  const auto formula = std::make_shared<const FormulaSteps>(std::move(steps));
  Function recorded =
      detail::recorded_function(std::make_shared<const StepsBody>(formula, name, false));
  return recorded ? recorded : Function(std::make_shared<const StepsBody>(formula, name, true));
}

}  // namespace saltus
