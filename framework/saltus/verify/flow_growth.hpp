// How errors of the state grow along a plan: the derivative of the flow, one factor per step.
#pragma once

#include <vector>

#include "saltus/core/dense_lu.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// Largest singular value of a matrix.
double largest_singular_value(MatrixXd matrix);

/// d state / d start along a plan, and the deviation of the open loop from the plan to first order.
/// A step multiplies by exp(h J) with the Jacobian J in its middle, to the accuracy that a growth
/// factor needs.
class FlowGrowth {
 public:
  /// Identity, no deviation, of n states.
  void begin(int n);
  /// `jacobian` (n x n by rows) times the length of the step.
  void step(const std::vector<double>& jacobian, double length);
  /// The planned state behind the interval differs from the integrated one by `gap`.
  void add_deviation(const VectorXd& gap) { columns_.col(columns_.cols() - 1) += gap; }
  /// Through a jump with this derivative.
  void jump(const MatrixXd& derivative) { columns_ = (derivative * columns_).eval(); }

  /// State of the open loop minus that of the plan.
  VectorXd deviation() const { return columns_.col(columns_.cols() - 1); }
  /// Largest factor by which an error has grown, relative to units at the start and here.
  double growth(const VectorXd& start_units, const VectorXd& units) const;

 private:
  void multiply(const MatrixXd& by, const std::vector<double>& jacobian, double length);

  MatrixXd columns_;  // of the derivative, then the deviation
  MatrixXd term_, product_;
};

}  // namespace saltus
