#include "saltus/solver/barrier_step.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

// Constants of the paper.
constexpr double first_shift = 1e-4, least_shift = 1e-20, largest_shift = 1e20;
constexpr double fast_growth = 100.0, slow_growth = 8.0, decay = 1.0 / 3.0;
// shift of the rows, times mu^(1/4), with the lower limit below
constexpr double dependent_rows = 1e-8;
constexpr double least_row_shift = 1e-9;
// Backward errors: no refinement needed; another factorisation is tried; the solution is rejected.
constexpr double exact = 1e-15, accurate = 1e-10, useless = 1e-5;
constexpr int refinements = 8;
constexpr double worthwhile = 0.5;

double largest(const VectorXd& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

}  // namespace

BarrierStep::BarrierStep(qp::NewtonSystem& system, int variables, int rows) : system_(system) {
  for (VectorXd* v : {&rest_w_, &more_w_, &trial_w_, &best_w_}) *v = VectorXd::Zero(variables);
  for (VectorXd* v : {&rest_r_, &more_r_, &trial_r_, &best_r_}) *v = VectorXd::Zero(rows);
}

bool BarrierStep::factor(const qp::SparseQp& qp, const VectorXd& variable_weights,
                         const VectorXd& row_weights, double mu) {
  qp_ = &qp;
  variable_weights_ = variable_weights;
  row_weights_ = row_weights;
  mu_ = mu;
  hessian_size_ = largest(qp.hessian);
  row_size_ = largest(qp.rows);
  shift_ = row_shift_ = 0.0;
  if (!system_.load(qp)) return false;
  return factor_shifted() || correct();
}

bool BarrierStep::factor_shifted() {
  shifted_variables_ = variable_weights_.array() + shift_;
  shifted_rows_ = row_weights_;
  for (double& w : shifted_rows_) {
    if (w == 0.0) continue;
    if (w < infinity)
      w = 1.0 / (1.0 / (w + shift_) + row_shift_);  // the slack of the row is a variable too
    else if (row_shift_ > 0.0)
      w = 1.0 / row_shift_;
  }
  return system_.factor(shifted_variables_, shifted_rows_);
}

bool BarrierStep::shift_rows() {
  if (row_shift_ > 0.0) return false;
  row_shift_ = std::max(least_row_shift, dependent_rows * std::pow(mu_, 0.25));
  return factor_shifted() || correct();
}

bool BarrierStep::correct() {
  const double growth = last_shift_ == 0.0 ? fast_growth : slow_growth;
  shift_ = shift_ > 0.0         ? growth * shift_
           : last_shift_ == 0.0 ? first_shift
                                : std::max(least_shift, decay * last_shift_);
  for (; shift_ <= largest_shift; shift_ *= growth) {
    if (!factor_shifted()) continue;
    last_shift_ = shift_;
    return true;
  }
  return false;
}

bool BarrierStep::solve(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda) {
  double smallest = infinity;
  const auto try_again = [&] {
    const double error = refine(rw, rr, trial_w_, trial_r_);
    if (!(error < smallest)) return;
    smallest = error;
    best_w_ = trial_w_;
    best_r_ = trial_r_;
  };
  try_again();
  if (smallest > accurate && system_.factor_with_fallback()) try_again();
  if (smallest > accurate && row_shift_ == 0.0) {  // rows may be dependent
    row_shift_ = std::max(least_row_shift, dependent_rows * std::pow(mu_, 0.25));
    if (factor_shifted()) try_again();
  }
  while (smallest > accurate && system_.factor_with_fallback()) try_again();
  dw = best_w_;
  dlambda = best_r_;
  accuracy_ = smallest;
  return smallest <= useless;
}

// Largest backward error of the two parts.
double BarrierStep::residual(const VectorXd& rw, const VectorXd& rr, const VectorXd& dw,
                             const VectorXd& dlambda) {
  const qp::SparseQp& qp = *qp_;
  double terms_w = std::max(hessian_size_ * largest(dw), row_size_ * largest(dlambda));
  double terms_r = row_size_ * largest(dw);
  for (int i = 0; i < rest_w_.size(); ++i) {
    const double bent = shifted_variables_[i] * dw[i];
    rest_w_[i] = rw[i] + bent;
    terms_w = std::max({terms_w, std::abs(rw[i]), std::abs(bent)});
  }
  for (int i = 0; i < rest_r_.size(); ++i) {
    if (shifted_rows_[i] == 0.0) {
      rest_r_[i] = 0.0;
      continue;
    }
    const double moved = dlambda[i] / shifted_rows_[i];
    rest_r_[i] = rr[i] - moved;
    terms_r = std::max({terms_r, std::abs(rr[i]), std::abs(moved)});
  }
  qp.hessian_pattern.for_each([&](int i, int j, int e) {
    rest_w_[i] += qp.hessian[e] * dw[j];
    if (i != j) rest_w_[j] += qp.hessian[e] * dw[i];
  });
  qp.row_pattern.for_each([&](int i, int j, int e) {
    if (shifted_rows_[i] == 0.0) return;
    rest_r_[i] += qp.rows[e] * dw[j];
    rest_w_[j] += qp.rows[e] * dlambda[i];
  });
  for (int i = 0; i < rest_w_.size(); ++i)
    if (qp.lower[i] == qp.upper[i]) rest_w_[i] = 0.0;
  const double of_w = largest(rest_w_), of_r = largest(rest_r_);
  const double error =
      std::max(of_w > 0.0 ? of_w / terms_w : 0.0, of_r > 0.0 ? of_r / terms_r : 0.0);
  if (!std::isfinite(error) || !dw.allFinite() || !dlambda.allFinite()) return infinity;
  return error;
}

double BarrierStep::refine(const VectorXd& rw, const VectorXd& rr, VectorXd& dw,
                           VectorXd& dlambda) {
  system_.solve(rw, rr, dw, dlambda);
  double error = residual(rw, rr, dw, dlambda);
  for (int round = 0; round < refinements && error > exact; ++round) {
    system_.solve(rest_w_, rest_r_, more_w_, more_r_);
    more_w_ += dw;
    more_r_ += dlambda;
    const double next = residual(rw, rr, more_w_, more_r_);
    if (next < error) {
      dw.swap(more_w_);
      dlambda.swap(more_r_);
    }
    const bool helps = next < worthwhile * error;
    error = std::min(error, next);
    if (!helps) break;
  }
  return error;
}

}  // namespace saltus
