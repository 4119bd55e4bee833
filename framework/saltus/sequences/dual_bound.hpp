// How low can the cost of a quadratic program in stages be? A bound from below by weak duality,
//
//     d(y, m) = min over v of  cost(v) + y'(A x + B u + b - x_next) + m'(M v - side),
//
// which holds for every y and every m of the right sign, however well they were computed. With the
// costs left out a positive bound is a proof (Farkas) that the program has no feasible point. The
// minimum is bounded in turn from the point v* where the multipliers were found: with r the
// gradient of the Lagrangian there and H its Hessian, cost(v) >= cost(v*) + r'd + 1/2 d'H d.
#pragma once

#include <vector>

#include "saltus/qp/stage_qp.hpp"

namespace saltus {

/// What holds the inputs of a stage back besides its bounds and rows.
struct InputHold {
  VectorXd radius;  ///< no feasible input is larger; entries may be infinite
  /// Directions of (x, u) in which the cost of the stage curves, and how much; made when first
  /// asked for, and of no use for a stage of another Hessian.
  MatrixXd directions = {};
  VectorXd curvature = {};
};

/// No feasible point costs less. `enough`: a better bound is not looked for. `holds`: one per
/// stage. Multipliers of bounds are not read: they are what is left of the gradient. Where
/// variables have no bounds, costates are chosen so that nothing is left for states, and inputs are
/// held by the curvature of the cost. An input that neither holds is taken to be within a multiple
/// of its size.
double dual_bound(const StageQp& qp, const StagePoint& point, const std::vector<InputHold*>& holds,
                  double enough);

/// Whether the multipliers of the point prove that the program has no feasible point. Inputs
/// without bounds are taken to be below 1e8 in the units of the stages.
bool proves_infeasible(const StageQp& qp, const StagePoint& point,
                       const std::vector<InputHold*>& holds);

/// Eigenvalues of a symmetric matrix, in increasing order. Compiled once, because Eigen's template
/// takes five seconds.
VectorXd eigenvalues_of(const MatrixXd& symmetric);

}  // namespace saltus
