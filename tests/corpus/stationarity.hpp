// Is a plan a KKT point of the problem as it was written? Single shooting over the plan's inputs
// and durations, exact derivatives by complex steps, multipliers by non-negative least squares:
// nothing is shared with the framework.
//
//     min over lambda >= 0 (inequalities), mu (equalities) of  | S (grad J + A' lambda + B' mu) |,
//
// with the rows within 1e-4 of their bounds and S the sizes of the variables. The residual times
// the size of its variable is the gain in cost that the first-order conditions still promise; it is
// relative to |J| and the largest such product of the gradient itself.
#pragma once

#include <string>
#include <vector>

#include "tests/corpus/outside.hpp"

namespace saltus::corpus {

struct Stationarity {
  double residual = 0.0;  ///< relative promised gain
  std::string variable;   ///< where it is largest
};
Stationarity stationarity(const std::vector<OutsidePhase>& phases,
                          const std::vector<PlanPiece>& plan, double cost_scale = 0.0);

/// x >= 0 (entries of `free` may be negative) that minimises |A x - b|: Lawson and Hanson.
VectorXd non_negative_least_squares(const MatrixXd& a, const VectorXd& b,
                                    const std::vector<bool>& free);

}  // namespace saltus::corpus
