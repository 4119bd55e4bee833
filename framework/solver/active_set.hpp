// What second derivatives say on the surface of the active rows: is a model convex there, and where
// is its stationary point?
//
// With A w = b the active rows and A' = Q R P' every point of the surface is w = w_p + Z p, where
// the columns of Z are those of Q beyond the rank of A. The eigenvalues of Z'HZ tell whether the
// model is convex there, and, Z being orthonormal, H + shift I adds the shift to each of them. The
// stationary point is where Z'HZ p = -Z'(g + H w_p); R P'y = -Q_1'(g + H w) gives its multipliers.
// That is Newton's step for the Lagrangian: quadratic near a solution, also where the model is not
// convex off the surface, and unharmed by dependent rows.
//
// Dense and with its own memory: for nonlinear programs solved offline.
#pragma once

#include <vector>

#include "framework/qp/sparse_qp.hpp"

namespace saltus {

class ActiveSet {
 public:
  /// Equality rows and fixed variables.
  static ActiveSet equalities(const SparseQp& qp);
  /// Also the rows and bounds that hold the cost up at a primal-dual solution.
  static ActiveSet at(const SparseQp& qp, const PrimalDualPoint& point);

  /// How much the diagonal of the Hessian lacks to be convex on the surface, where its eigenvalues
  /// then are at least `floor` times the largest; zero if it is convex. Infinite for programs of
  /// more than `largest` variables, for which the answer would take too long.
  double missing_curvature(const SparseQp& qp, double floor) const;
  /// The stationary point on the surface, once the curvature that is missing there was added.
  /// False when there are too many variables, or numbers fail.
  bool solve(const SparseQp& qp, double floor, PrimalDualPoint& point) const;

  static constexpr int largest = 1500;

 private:
  // +1: at the upper side, -1: at the lower side, 0: not active.
  std::vector<int> rows_, bounds_;
};

}  // namespace saltus
