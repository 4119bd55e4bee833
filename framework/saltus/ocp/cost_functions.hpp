// Costs as functions: what the transcription sums once terms are composed from formulas.
#pragma once

#include <memory>
#include <vector>

#include "saltus/model/function.hpp"
#include "saltus/ocp/reference.hpp"
#include "saltus/ocp/term.hpp"

namespace saltus {

/// What a cost term adds: its formula, or half the weighted square of it.
Function cost_function(const Term& term);

/// y = 1/2 (r(z) - ref(t))' W (r(z) - ref(t)) with t = z[0]; one output. Its Gauss-Newton Hessian
/// is r_z' W r_z, the exact one adds the curvature of r.
Function least_squares_cost(const Function& residual, const MatrixXd& weight,
                            const Reference& reference);

/// All outputs of functions of the same argument, one after the other.
Function stack(const std::vector<Function>& functions);

/// A stack of functions of which some can be left out, as running costs outside their windows: a
/// formula need not have a value there. The outputs of those left out are zero.
class SelectiveStack {
 public:
  /// Empty.
  SelectiveStack() = default;
  /// Of at least one function. Evaluates all of them.
  explicit SelectiveStack(std::vector<Function> parts);

  /// The stack; follows evaluate().
  const Function& function() const { return function_; }
  /// How many functions there are.
  int size() const { return static_cast<int>(parts_.size()); }
  /// Whether function i is evaluated from now on.
  void evaluate(int i, bool wanted) const { (*wanted_)[i] = wanted ? 1 : 0; }
  /// Whether it is.
  bool is_evaluated(int i) const { return (*wanted_)[i] != 0; }
  /// The same for another thread, evaluating all; empty if a part cannot be separated.
  SelectiveStack separate() const;

 private:
  std::vector<Function> parts_;
  std::shared_ptr<std::vector<char>> wanted_;
  Function function_;
};

/// y = h L(z) as a function of (z | h): a node cost whose interval has an unknown length.
Function times_length(const Function& cost);

/// y_i = 1/2 weights[i] (b_i - a_i)^2 as a function of (a | b); one output per component.
Function change_costs(const VectorXd& weights);

}  // namespace saltus
