// The l1 merit function phi = f + sum_i nu_i violation_i(w), by which steps are judged.
//
// Exact where every weight nu_i exceeds |lambda_i|: its minima are then solutions. Weights follow
// the multipliers, up at once and down slowly (Powell), so that an early and large multiplier does
// not make later steps short. Nocedal and Wright, Numerical Optimization, 2nd ed., sec. 18.3.
#pragma once

#include "saltus/solver/quadratic_model.hpp"

namespace saltus {

class L1Merit {
 public:
  explicit L1Merit(const NonlinearProgram& program);

  /// Weights for a step that would lead to these multipliers, none below `least`.
  void update_weights(const VectorXd& lambda, double least);
  /// From here on steps begin where the model was linearised.
  void start_at(NonlinearProgram& program, const QuadraticModel& model);
  /// Change of phi that the model predicts for w, of first order in the cost.
  double predicted_change(const NonlinearProgram& program, const QuadraticModel& model,
                          const VectorXd& w);
  /// Armijo: whether phi at w lies below its start by a fixed fraction of `predicted`, < 0.
  /// False where the program cannot be evaluated. rows() are then those at w.
  bool decreases_enough(NonlinearProgram& program, const VectorXd& w, double predicted);
  /// Differences of phi below this are rounding.
  double noise() const { return noise_; }
  const VectorXd& rows() const { return rows_; }

 private:
  double penalty_of(const NonlinearProgram& program, const VectorXd& rows) const;

  VectorXd weight_;
  VectorXd rows_;
  double phi_ = 0.0, noise_ = 0.0;
};

/// Sum of all violations of the rows with these values.
double total_violation(const NonlinearProgram& program, const VectorXd& rows);

}  // namespace saltus
