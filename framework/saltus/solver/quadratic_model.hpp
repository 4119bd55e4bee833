// The quadratic model of a program at a point: what sequential quadratic programming solves.
//
//     min f + g'(w - w0) + 1/2 (w - w0)'H(w - w0)   subject to the bounds and
//     row_lower <= c + J (w - w0) <= row_upper
//
// It is posed in w itself and not in the step, so that bounds stay as they are, a solution is a
// point of the program, and its multipliers are the new multipliers.
#pragma once

#include <vector>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Sized once for a program; after construction nothing allocates.
class QuadraticModel {
 public:
  /// The Hessian has the pattern of the program's; unless that is linear-quadratic, with the whole
  /// diagonal, so that it can be convexified.
  explicit QuadraticModel(const NonlinearProgram& program);

  /// Evaluates everything at w. `lambda` are the multipliers of the Hessian. False where the
  /// program cannot be evaluated.
  bool linearise(NonlinearProgram& program, const VectorXd& w, const VectorXd& lambda,
                 Curvature curvature);
  /// The same without the rows' entries, which stand elsewhere; `rows_times_w` is J w.
  bool linearise(NonlinearProgram& program, const VectorXd& w, const VectorXd& lambda,
                 Curvature curvature, const VectorXd& rows_times_w);
  /// Hessian alone, at the w of the last linearise().
  bool set_curvature(NonlinearProgram& program, const VectorXd& lambda, Curvature curvature);
  /// To be called after the Hessian's entries were changed from outside, and by nobody else.
  void hessian_changed();
  /// Bounds of variables and rows as they are now, everything else as linearised.
  void update_bounds(const NonlinearProgram& program);
  /// Second-order correction: the rows as if they had the values `c` at w.
  void correct_rows(const NonlinearProgram& program, const VectorXd& w, const VectorXd& c);

  SparseQp& qp() { return qp_; }
  const SparseQp& qp() const { return qp_; }
  // At the point of linearisation.
  const VectorXd& w() const { return w0_; }
  double cost() const { return cost_; }
  const VectorXd& gradient() const { return gradient_; }
  const VectorXd& constraints() const { return c_; }

 private:
  bool evaluate(NonlinearProgram& program, const VectorXd& w);
  void shift_rows(const NonlinearProgram& program);

  SparseQp qp_;
  std::vector<int> position_;  // of the program's Hessian entries; empty: the same
  VectorXd hessian_;           // in the program's pattern
  VectorXd w0_, gradient_, c_;
  VectorXd offset_;  // c - J w0
  double cost_ = 0.0;
};

/// out = H v with H given by its lower triangle.
void multiply_symmetric(const SparsityPattern& pattern, const VectorXd& entries, const VectorXd& v,
                        VectorXd& out);
/// out = J v.
void multiply(const SparsityPattern& pattern, const VectorXd& entries, const VectorXd& v,
              VectorXd& out);

}  // namespace saltus
