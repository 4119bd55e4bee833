// The quadratic model of a program at a point, as sequential quadratic programming solves it:
//
//     min f + g'(w - w0) + 1/2 (w - w0)'H(w - w0)   subject to the bounds and
//     row_lower <= c + J (w - w0) <= row_upper
//
// The model is stated in w instead of the step: bounds stay unchanged, a solution is a point of the
// program, and its multipliers are the new multipliers.
#pragma once

#include <vector>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Allocated once for a program; later calls do not allocate.
class QuadraticModel {
 public:
  /// The Hessian has the pattern of the program. Unless the program is linear-quadratic, the
  /// pattern includes the whole diagonal for convexification.
  explicit QuadraticModel(const NonlinearProgram& program);

  /// Evaluates the model at w. `lambda` are the multipliers of the Hessian. Returns false if the
  /// program cannot be evaluated.
  bool linearise(NonlinearProgram& program, const VectorXd& w, const VectorXd& lambda,
                 Curvature curvature);
  /// The same without the entries of the rows, which are stored elsewhere. `rows_times_w` is J w.
  bool linearise(NonlinearProgram& program, const VectorXd& w, const VectorXd& lambda,
                 Curvature curvature, const VectorXd& rows_times_w);
  /// Evaluates the Hessian alone, at the w of the last linearise().
  bool set_curvature(NonlinearProgram& program, const VectorXd& lambda, Curvature curvature);
  /// Must be called after the Hessian entries were changed through qp().
  void hessian_changed();
  /// Updates the bounds of variables and rows; everything else stays as linearised.
  void update_bounds(const NonlinearProgram& program);
  /// Second-order correction: shifts the rows as if they had the values `c` at w.
  void correct_rows(const NonlinearProgram& program, const VectorXd& w, const VectorXd& c);

  qp::SparseQp& qp() { return qp_; }
  const qp::SparseQp& qp() const { return qp_; }
  // Values at the linearisation point.
  const VectorXd& w() const { return w0_; }
  double cost() const { return cost_; }
  const VectorXd& gradient() const { return gradient_; }
  const VectorXd& constraints() const { return c_; }

 private:
  bool evaluate(NonlinearProgram& program, const VectorXd& w);
  void shift_rows(const NonlinearProgram& program);

  qp::SparseQp qp_;
  std::vector<int> position_;  // positions of the program's Hessian entries; empty: identical
  VectorXd hessian_;           // in the program's pattern
  VectorXd w0_, gradient_, c_;
  VectorXd offset_;  // c - J w0
  double cost_ = 0.0;
};

/// Computes out = H v with H given by its lower triangle.
void multiply_symmetric(const SparsityPattern& pattern, const VectorXd& entries, const VectorXd& v,
                        VectorXd& out);
/// Computes out = J v.
void multiply(const SparsityPattern& pattern, const VectorXd& entries, const VectorXd& v,
              VectorXd& out);

}  // namespace saltus
