// The seam between methods that take one Newton step per point and the linear algebra of a
// program's structure.
#pragma once

#include <memory>

#include "saltus/qp/sparse_qp.hpp"

namespace saltus {

/// The equations of a step of the barrier method, H and J as last loaded:
///
///     [ H + diag(variable weights)   J'                     ] [ dw      ]      [ rw ]
///     [ J                            -diag(1 / row weights) ] [ dlambda ] = -  [ rr ]
///
/// An infinite row weight is an equality, a vanishing one no row. Fixed variables do not move.
class NewtonSystem {
 public:
  virtual ~NewtonSystem() = default;
  /// Before a method's first factor: what earlier runs have taught is forgotten, so that the same
  /// start always leads to the same steps.
  virtual void restart() {}
  /// Takes H and J, and from the bounds which variables are fixed, which rows equalities and which
  /// sides exist; gradient and values of bounds are not read. False if the structure cannot express
  /// it, or where an entry is not finite.
  virtual bool load(const SparseQp& qp) = 0;
  /// False if H + diag(variable weights) is not convex where the equalities hold (with the other
  /// rows as penalties), or if the factor broke down.
  virtual bool factor(const VectorXd& variable_weights, const VectorXd& row_weights) = 0;
  /// Of limited accuracy: meant to be refined.
  virtual void solve(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda) = 0;
  /// Factors once more in another way, where refinement does not converge; false if there is none
  /// left to try.
  virtual bool factor_otherwise() { return false; }
};

}  // namespace saltus
