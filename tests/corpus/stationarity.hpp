// Tests whether a plan is a KKT point of the original problem. It uses single shooting over the
// plan's inputs and durations, exact derivatives by complex steps, and multipliers by non-negative
// least squares. It shares no code with the framework.
//
//     min over lambda >= 0 (inequalities), mu (equalities) of  | S (grad J + A' lambda + B' mu) |,
//
// with the rows within 1e-4 of their bounds, and S the sizes of the variables. The residual times
// the size of its variable is the cost decrease that the first-order conditions still promise. It
// is relative to |J| and to the largest such product of the gradient itself.
#pragma once

#include <string>
#include <vector>

#include "tests/corpus/outside.hpp"

namespace saltus::corpus {

struct Stationarity {
  double residual = 0.0;  ///< relative promised gain
  std::string variable;   ///< variable with the largest residual
};
Stationarity stationarity(const std::vector<OutsidePhase>& phases,
                          const std::vector<PlanPiece>& plan, double cost_scale = 0.0);

/// Minimises |A x - b| over x >= 0 by the method of Lawson and Hanson. Entries of `free` have no
/// sign constraint.
VectorXd non_negative_least_squares(const MatrixXd& a, const VectorXd& b,
                                    const std::vector<bool>& free);

}  // namespace saltus::corpus
