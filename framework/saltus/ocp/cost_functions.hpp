// Cost terms as functions that the transcription adds up.
#pragma once

#include <memory>
#include <vector>

#include "saltus/model/function.hpp"
#include "saltus/ocp/term.hpp"

namespace saltus {

/// Cost of a term: its formula, or half the weighted square of its residual.
Function cost_function(const Term& term);

/// y = 1/2 (r(z) - ref(t))' W (r(z) - ref(t)) with t = z[0], one output. The Gauss-Newton Hessian
/// is r_z' W r_z. The exact Hessian adds the curvature of r.
Function least_squares_cost(const Function& residual, const MatrixXd& weight,
                            const Reference& reference);

/// Concatenates the outputs of functions of the same argument.
Function stack(const std::vector<Function>& functions);

/// A stack of functions that can be switched off one by one. Running costs are off outside their
/// windows, where a formula may be undefined. Outputs of functions that are off are zero.
class SelectiveStack {
 public:
  /// An empty stack.
  SelectiveStack() = default;
  /// A stack of at least one function. All functions are on.
  explicit SelectiveStack(std::vector<Function> parts);

  /// The stack as one function. It follows calls of evaluate().
  const Function& function() const { return function_; }
  /// Number of functions.
  int size() const { return static_cast<int>(parts_.size()); }
  /// Switches function i on or off.
  void evaluate(int i, bool wanted) const { (*wanted_)[i] = wanted ? 1 : 0; }
  /// True if function i is on.
  bool is_evaluated(int i) const { return (*wanted_)[i] != 0; }
  /// A copy for another thread with all functions on. Empty if a part cannot be separated.
  SelectiveStack separate() const;

 private:
  std::vector<Function> parts_;
  std::shared_ptr<std::vector<char>> wanted_;
  Function function_;
};

/// y = h L(z) as a function of (z | h): cost of a node whose interval has a free length.
Function times_length(const Function& cost);

/// y_i = 1/2 weights[i] (b_i - a_i)^2 as a function of (a | b). One output per component.
Function change_costs(const VectorXd& weights);

}  // namespace saltus
