// Growth of state errors along a plan: the derivative of the flow as a product of step factors.
#pragma once

#include <vector>

#include "saltus/core/dense_lu.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// Largest singular value of a matrix.
double largest_singular_value(MatrixXd matrix);

/// d state / d start along a plan, and the first-order deviation of the open loop from the plan. A
/// step multiplies by exp(h J) with the Jacobian J at its midpoint, which is accurate enough for a
/// growth factor.
class FlowGrowth {
 public:
  /// Starts with the identity and no deviation, for n states.
  void begin(int n);
  /// Multiplies by a step. `jacobian` is n x n by rows, multiplied by the step length.
  void step(const std::vector<double>& jacobian, double length);
  /// Adds `gap`, the planned state after an interval minus the integrated one.
  void add_deviation(const VectorXd& gap) { columns_.col(columns_.cols() - 1) += gap; }
  /// Multiplies by the derivative of a jump.
  void jump(const MatrixXd& derivative) { columns_ = (derivative * columns_).eval(); }

  /// State of the open loop minus that of the plan.
  VectorXd deviation() const { return columns_.col(columns_.cols() - 1); }
  /// Largest growth factor of an error, relative to the units at the start and here.
  double growth(const VectorXd& start_units, const VectorXd& units) const;

 private:
  void multiply(const MatrixXd& by, const std::vector<double>& jacobian, double length);

  MatrixXd columns_;  // columns of the derivative, then the deviation
  MatrixXd term_, product_;
};

}  // namespace saltus
