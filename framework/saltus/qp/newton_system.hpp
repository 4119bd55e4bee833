// Interface between methods that take one Newton step per point and the linear algebra of the
// program structure.
#pragma once

#include <memory>

#include "saltus/qp/sparse_qp.hpp"

namespace saltus {

/// The equations of a barrier step, with H and J from the last load():
///
///     [ H + diag(variable weights)   J'                     ] [ dw      ]      [ rw ]
///     [ J                            -diag(1 / row weights) ] [ dlambda ] = -  [ rr ]
///
/// An infinite row weight makes the row an equality; a zero weight removes it. Fixed variables do
/// not move.
class NewtonSystem {
 public:
  virtual ~NewtonSystem() = default;
  /// Forgets what earlier runs have learned, so that the same start always gives the same steps.
  /// Call it before the first factor() of a run.
  virtual void restart() {}
  /// Takes H and J. The bounds determine which variables are fixed, which rows are equalities and
  /// which sides exist; the gradient and the bound values are not read. Returns false if the
  /// structure cannot express the program or an entry is not finite.
  virtual bool load(const SparseQp& qp) = 0;
  /// Returns false if H + diag(variable weights) is not convex where the equalities hold (with the
  /// other rows as penalties), or if the factorisation broke down.
  virtual bool factor(const VectorXd& variable_weights, const VectorXd& row_weights) = 0;
  /// Solves for the step. The accuracy is limited; the caller refines the solution.
  virtual void solve(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda) = 0;
  /// Factors again with another method if refinement does not converge. Returns false if no other
  /// method is left.
  virtual bool factor_otherwise() { return false; }
};

}  // namespace saltus
