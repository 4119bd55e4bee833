// The l1 merit function phi = f + sum_i nu_i violation_i(w), which accepts or rejects steps.
//
// It is exact if every weight nu_i exceeds |lambda_i|: its minima are then solutions. Weights
// increase with the multipliers at once and decrease slowly (Powell), so that an early large
// multiplier does not shorten later steps. Nocedal and Wright, Numerical Optimization, 2nd ed.,
// sec. 18.3.
#pragma once

#include "saltus/solver/quadratic_model.hpp"

namespace saltus {

class L1Merit {
 public:
  explicit L1Merit(const NonlinearProgram& program);

  /// Updates the weights for a step to these multipliers. No weight is below `least`.
  void update_weights(const VectorXd& lambda, double least);
  /// Sets the start of the following steps to the linearisation point of the model.
  void start_at(NonlinearProgram& program, const QuadraticModel& model);
  /// Change of phi that the model predicts for w, first order in the cost.
  double predicted_change(const NonlinearProgram& program, const QuadraticModel& model,
                          const VectorXd& w);
  /// Armijo condition: true if phi at w is below its start by a fixed fraction of `predicted` < 0.
  /// False if the program cannot be evaluated. Afterwards rows() holds the rows at w.
  bool decreases_enough(NonlinearProgram& program, const VectorXd& w, double predicted);
  /// Differences of phi below this are rounding errors.
  double noise() const { return noise_; }
  const VectorXd& rows() const { return rows_; }

 private:
  double penalty_of(const NonlinearProgram& program, const VectorXd& rows) const;

  VectorXd weight_;
  VectorXd rows_;
  double phi_ = 0.0, noise_ = 0.0;
};

/// Sum of the violations of all rows with these values.
double total_violation(const NonlinearProgram& program, const VectorXd& rows);

}  // namespace saltus
