#include "saltus/solver/l1_merit.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

constexpr double armijo = 1e-4;     // fraction of the predicted decrease, the usual value
constexpr double rounding = 1e-13;  // relative to the merit function

double violation(double value, double lower, double upper) {
  return std::max({lower - value, value - upper, 0.0});
}

}  // namespace

double total_violation(const NonlinearProgram& program, const VectorXd& rows) {
  double sum = 0.0;
  for (int i = 0; i < rows.size(); ++i)
    sum += violation(rows[i], program.row_lower()[i], program.row_upper()[i]);
  return sum;
}

L1Merit::L1Merit(const NonlinearProgram& program)
    : weight_(VectorXd::Zero(program.rows())), rows_(VectorXd::Zero(program.rows())) {}

void L1Merit::update_weights(const VectorXd& lambda, double least) {
  for (int i = 0; i < weight_.size(); ++i) {
    const double l = std::abs(lambda[i]);
    weight_[i] = std::max({1.1 * l, 0.5 * (weight_[i] + l), least});
  }
}

void L1Merit::start_at(NonlinearProgram& program, const QuadraticModel& model) {
  phi_ = model.cost() + penalty_of(program, model.constraints());
  noise_ = rounding * (std::abs(model.cost()) + std::abs(phi_) + 1.0);
}

double L1Merit::predicted_change(const NonlinearProgram& program, const QuadraticModel& model,
                                 const VectorXd& w) {
  const VectorXd d = w - model.w();
  multiply(model.qp().row_pattern, model.qp().rows, d, rows_);
  rows_ += model.constraints();
  return model.gradient().dot(d) + penalty_of(program, rows_) -
         penalty_of(program, model.constraints());
}

bool L1Merit::decreases_enough(NonlinearProgram& program, const VectorXd& w, double predicted) {
  double f = 0.0;
  if (!program.objective(w.data(), f) || !program.constraints(w.data(), rows_.data())) return false;
  const double phi = f + penalty_of(program, rows_);
  return std::isfinite(phi) && phi <= phi_ + armijo * predicted + noise_;
}

double L1Merit::penalty_of(const NonlinearProgram& program, const VectorXd& rows) const {
  double sum = 0.0;
  for (int i = 0; i < rows.size(); ++i)
    sum += weight_[i] * violation(rows[i], program.row_lower()[i], program.row_upper()[i]);
  return sum;
}

}  // namespace saltus
