// Lower bounds on the optimal cost of a staged quadratic program by weak duality:
//
//     d(y, m) = min over v of  cost(v) + y'(A x + B u + b - x_next) + m'(M v - side),
//
// It holds for every y and every m of the right sign, however they were computed. With zero costs,
// a positive bound proves that the program is infeasible (Farkas). The minimum over v is bounded
// from below at the point v* of the multipliers. Let r be the gradient of the Lagrangian at v* and
// H its Hessian: cost(v) >= cost(v*) + r'd + 1/2 d'H d.
#pragma once

#include <vector>

#include "saltus/qp/stage_qp.hpp"

namespace saltus {

/// Limits of the inputs of a stage in addition to its bounds and rows.
struct InputHold {
  VectorXd radius;  ///< bound on the magnitude of each feasible input; may be infinite
  /// Directions of (x, u) with curvature of the stage cost, and the curvatures. Computed on first
  /// use. Valid only for stages with the same Hessian.
  MatrixXd directions = {};
  VectorXd curvature = {};
};

/// Lower bound on the cost of every feasible point. Stops improving the bound once it exceeds
/// `enough`. `holds` has one entry per stage. Bound multipliers are not read: the remaining
/// gradient determines them. If states have no bounds, costates are chosen so that their gradient
/// vanishes. The curvature of the cost limits the inputs. An input without any limit is assumed to
/// stay within a multiple of its magnitude.
double dual_bound(const qp::StageQp& qp, const qp::StagePoint& point,
                  const std::vector<InputHold*>& holds, double enough);

/// True if the multipliers of the point prove that the program is infeasible. Assumes that inputs
/// without bounds stay below 1e8 in the units of the stages.
bool proves_infeasible(const qp::StageQp& qp, const qp::StagePoint& point,
                       const std::vector<InputHold*>& holds);

/// Eigenvalues of a symmetric matrix in increasing order. Compiled once, because Eigen's template
/// takes five seconds to compile.
VectorXd eigenvalues_of(const MatrixXd& symmetric);

}  // namespace saltus
