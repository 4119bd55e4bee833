// Newton's step on the barrier equations: solved to full accuracy, and a descent direction if the
// rows are satisfied.
#pragma once

#include "saltus/qp/sparse_qp.hpp"

namespace saltus {

/// Factors [H + W + shift I, J'; J, -1/V - row shift] with the smallest shift that makes H convex
/// along the rows (Waechter and Biegler, Math. Program. 106, 2006, sec. 3.1). Solves the system
/// with iterative refinement.
class BarrierStep {
 public:
  BarrierStep(qp::NewtonSystem& system, int variables, int rows);

  /// Uses H and J of `qp`, and weights as in qp::NewtonSystem. `mu` scales the shift of dependent
  /// rows. Returns false if no shift succeeds.
  bool factor(const qp::SparseQp& qp, const VectorXd& variable_weights, const VectorXd& row_weights,
              double mu);
  /// Returns false if the solution is too inaccurate; correct() may then lead to a better one.
  bool solve(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda);
  /// Factors with larger shifts than the last factor.
  bool correct();
  /// Factors again with a shift of the rows, which bounds the multipliers of rows that nearly
  /// contradict each other or the weights. Returns false if the rows are shifted already.
  bool shift_rows();

  double shift() const { return shift_; }
  double row_shift() const { return row_shift_; }
  double accuracy() const { return accuracy_; }  ///< backward error of the last solution

 private:
  bool factor_shifted();
  double residual(const VectorXd& rw, const VectorXd& rr, const VectorXd& dw,
                  const VectorXd& dlambda);
  double refine(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda);

  qp::NewtonSystem& system_;
  const qp::SparseQp* qp_ = nullptr;
  VectorXd variable_weights_, row_weights_, shifted_variables_, shifted_rows_;
  VectorXd rest_w_, rest_r_, more_w_, more_r_, trial_w_, trial_r_, best_w_, best_r_;
  double hessian_size_ = 0.0, row_size_ = 0.0, mu_ = 0.0;
  double accuracy_ = 0.0;
  double shift_ = 0.0, last_shift_ = 0.0, row_shift_ = 0.0;
};

}  // namespace saltus
