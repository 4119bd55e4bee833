// The l1 merit function phi = f + sum_i nu_i violation_i(w), by which steps are judged.
//
// Exact where every price nu_i exceeds |lambda_i|: its minima are then solutions. Prices follow the
// multipliers, up at once and down slowly (Powell), so that an early and large multiplier does not
// make later steps short. Nocedal and Wright, Numerical Optimization, 2nd ed., sec. 18.3.
#pragma once

#include "saltus/solver/quadratic_model.hpp"

namespace saltus {

class L1Merit {
 public:
  explicit L1Merit(const NonlinearProgram& program);

  /// Prices for a step that would lead to these multipliers, none below `least`.
  void follow(const VectorXd& lambda, double least);
  /// From here on steps begin where the model was linearised.
  void begin(NonlinearProgram& program, const QuadraticModel& model);
  /// Change of phi that the model promises for w, of first order in the cost.
  double promised(const NonlinearProgram& program, const QuadraticModel& model, const VectorXd& w);
  /// Whether phi at w lies below its start by a fixed share of `expected`, which is negative.
  /// False where the program cannot be evaluated. rows() are then those at w.
  bool falls(NonlinearProgram& program, const VectorXd& w, double expected);
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
