// Derivatives of a recorded formula, as programs that are built once and evaluated without
// allocation.
//
// The Jacobian is propagated forward from the inputs or backward from the outputs, whichever takes
// fewer operations. For the Hessian of a weighted sum, let b be the derivatives of the sum with
// respect to all nodes, computed backward. A direction d propagates forward as
//   t_i = sum_k (d f_i / d a_k) t_k
// and the derivative of b along d backward as
//   b'_k = sum_i (d f_i / d a_k) b'_i + sum_l (sum_i b_i d2 f_i / (d a_k d a_l)) t_l,
// where i are the nodes that use node k. At the inputs, b' is the Hessian times d.
#pragma once

#include <memory>
#include <vector>

#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/autodiff/scalar_program.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/model/direction_sweep.hpp"

namespace saltus::detail {

/// Programs for the Jacobian and the Hessian. Immutable after construction.
class RecordedDerivatives {
 public:
  /// Derivatives to record.
  struct Parts {
    bool jacobian = true;  ///< the Jacobian
    bool hessian = true;   ///< the Hessian of a weighted sum

    friend bool operator==(const Parts&, const Parts&) = default;
  };
  /// Numbers of one evaluation, for one thread at a time.
  struct Workspace {
    std::vector<double> slots;         ///< numbers of the scalar program
    std::vector<double> storage;       ///< contains both kinds of packs
    double* jacobian_packs = nullptr;  ///< packs of the Jacobian
    double* hessian_packs = nullptr;   ///< packs of the Hessian
  };

  /// Records the parts with the entries of the patterns. is_complete() is false if the formula has
  /// a step that cannot be recorded.
  RecordedDerivatives(const FormulaSteps& steps, const SparsityPattern& jacobian,
                      const SparsityPattern& hessian, Parts parts);

  /// True if the formula could be recorded.
  bool is_complete() const { return is_complete_; }
  /// Number of operations of a Jacobian.
  int jacobian_operations() const;
  /// Number of operations of a Hessian.
  int hessian_operations() const;
  /// A workspace for evaluations.
  Workspace workspace() const;

  /// Computes y and the entries of the Jacobian.
  void jacobian(const double* z, double* y, double* entries, Workspace& workspace) const;
  /// Computes the entries of the Hessian of the weighted sum.
  void hessian(const double* z, const double* weights, double* entries, Workspace& workspace) const;
  /// Computes all of them.
  void derivatives(const double* z, const double* weights, double* y, double* jacobian_entries,
                   double* hessian_entries, Workspace& workspace) const;

 private:
  void read_values(const Workspace& workspace, double* y) const;
  void load(const double* z, const double* weights, Workspace& workspace) const;

  int inputs_, outputs_;
  bool is_complete_ = false;
  ScalarProgram scalars_;    // part 0: values and Jacobian; part 1: Hessian
  std::vector<int> values_;  // slots of the outputs
  std::vector<DirectionSweep> jacobian_, hessian_;
};

/// The function with all derivatives from its recorded steps, also where dual numbers take fewer
/// operations. Empty if the formula has a step that cannot be recorded.
Function recorded_function(std::shared_ptr<const FunctionBody> formula);

/// Number of operations of dual numbers, comparable with those above.
long dual_operations(const FormulaSteps& steps, std::size_t passes);

}  // namespace saltus::detail
