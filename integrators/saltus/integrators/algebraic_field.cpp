#include "saltus/integrators/algebraic_field.hpp"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "saltus/core/workspace_pool.hpp"

namespace saltus {
namespace {

// (f | g) as a function of (t | x z | u | p), or a function of (t | x | u | p) with that argument.
// First derivatives only.
class Stacked final : public FunctionBody {
 public:
  Stacked(const Arguments& sizes, int nz, std::vector<Function> functions,
          detail::Lending lending = detail::Lending::shared)
      : FunctionBody(sizes.size() + nz, outputs_of(functions)),
        sizes_(sizes),
        functions_(std::move(functions)),
        first_(1 + sizes.nx),
        nz_(nz),
        workspaces_(lending) {
    std::vector<std::pair<int, int>> pairs;
    int row = 0;
    for (const Function& f : functions_) {
      const int skipped = reads_z(f) ? 0 : nz_;
      f.jacobian_pattern().for_each(
          [&](int r, int c, int) { pairs.emplace_back(row + r, c < first_ ? c : c + skipped); });
      row += f.outputs();
    }
    jacobian_pattern_ = SparsityPattern::from_pairs(outputs(), inputs(), std::move(pairs));
    hessian_pattern_ = SparsityPattern(inputs(), inputs());
    workspaces_.add(new_workspace());
  }
  bool is_reentrant() const override {
    return workspaces_.is_shared() &&
           std::all_of(functions_.begin(), functions_.end(),
                       [](const Function& f) { return f.is_reentrant(); });
  }
  std::shared_ptr<const FunctionBody> separate() const override {
    std::vector<Function> parts;
    for (const Function& f : functions_) {
      parts.push_back(f.separate());
      if (!parts.back()) return nullptr;
    }
    return std::make_shared<Stacked>(sizes_, nz_, std::move(parts), detail::Lending::exclusive);
  }
  void value(const double* z, double* y) const override {
    const Pool::Loan reduced = lend();
    for (const Function& f : functions_) {
      f.value(argument(f, z, *reduced), y);
      y += f.outputs();
    }
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    const Pool::Loan reduced = lend();
    for (const Function& f : functions_) {
      f.jacobian(argument(f, z, *reduced), y, entries);
      y += f.outputs();
      entries += f.jacobian_pattern().entries();
    }
  }
  void hessian(const double*, const double*, double*, Curvature) const override {}

 private:
  using Workspace = std::vector<double>;  // (t | x | u | p)
  using Pool = detail::WorkspacePool<Workspace>;

  std::unique_ptr<Workspace> new_workspace() const {
    return std::make_unique<Workspace>(sizes_.size());
  }
  Pool::Loan lend() const {
    return workspaces_.lend([this] { return new_workspace(); });
  }
  static int outputs_of(const std::vector<Function>& functions) {
    int count = 0;
    for (const Function& f : functions) count += f.outputs();
    return count;
  }
  bool reads_z(const Function& f) const { return f.inputs() == inputs(); }
  const double* argument(const Function& f, const double* z, Workspace& reduced) const {
    if (reads_z(f)) return z;
    std::copy_n(z, first_, reduced.begin());
    std::copy(z + first_ + nz_, z + inputs(), reduced.begin() + first_);
    return reduced.data();
  }

  Arguments sizes_;
  std::vector<Function> functions_;
  int first_, nz_;
  Pool workspaces_;
};

}  // namespace

IntervalProblem with_algebraic_states(const IntervalProblem& problem) {
  if (!problem.algebraic) return problem;
  const AlgebraicEquations& equations = *problem.algebraic.equations;
  const auto stacked = [&](std::vector<Function> functions) {
    return Function(std::unique_ptr<const FunctionBody>(
        std::make_unique<Stacked>(problem.arguments, equations.count(), std::move(functions))));
  };
  IntervalProblem extended = problem;
  extended.arguments = equations.extended();
  extended.dynamics = stacked({problem.algebraic.dynamics, equations.equations()});
  if (problem.running_cost) extended.running_cost = stacked({problem.running_cost});
  extended.nominal_state = {};
  return extended;
}

}  // namespace saltus
