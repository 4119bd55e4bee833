// The equations of the barrier problem at a point, and Newton's step.
#include "saltus/solver/barrier_run.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/solver/barrier_numbers.hpp"

namespace saltus {
namespace {

using barrier::excessive_multiplier;
using barrier::largest;

// Slope times mu that keeps variables with one side from diverging.
constexpr double damping = 1e-5;
// Steps shorter than this make no progress.
constexpr double useful_step = 0.1;
constexpr double multiplier_unit = 100.0;  // multipliers up to this size are not scaled

}  // namespace

double BarrierRun::barrier_cost(const VectorXd& x, double cost) const {
  double logarithms = 0.0, pull = 0.0;
  for (int i = 0; i < n_ + m_; ++i) {
    const bool has_lower = lower_[i] > -infinity, has_upper = upper_[i] < infinity;
    if (has_lower) logarithms += std::log(x[i] - lower_[i]);
    if (has_upper) logarithms += std::log(upper_[i] - x[i]);
    if (has_lower && !has_upper) pull += x[i] - lower_[i];
    if (has_upper && !has_lower) pull += upper_[i] - x[i];
  }
  return cost + mu_ * (damping * pull - logarithms);
}

// Evaluates cost and rows. Returns false if the program cannot be evaluated.
bool BarrierRun::evaluate(Trial& t) {
  if (!program_.objective(t.x.data(), t.cost) || !std::isfinite(t.cost) ||
      !program_.constraints(t.x.data(), t.rows.data()))
    return false;
  t.violation = 0.0;
  for (int i = 0; i < m_; ++i) {
    double& c = t.rows[i];
    if (row_kind_[i] == Row::free)
      c = 0.0;
    else
      c -= row_kind_[i] == Row::equality ? program_.row_lower()[i] : t.x[n_ + i];
    t.violation += std::abs(c);
  }
  t.barrier_cost = barrier_cost(t.x, t.cost);
  return std::isfinite(t.violation) && std::isfinite(t.barrier_cost);
}

bool BarrierRun::linearise() {
  return program_.gradient(now_.x.data(), gradient_.data()) &&
         program_.jacobian(now_.x.data(), engine_.qp.rows.data()) && gradient_.allFinite() &&
         engine_.qp.rows.allFinite();
}

void BarrierRun::compute_stationarity() {
  stationarity_ = z_upper_ - z_lower_;
  stationarity_.head(n_) += gradient_;
  engine_.qp.row_pattern.for_each(
      [&](int i, int j, int e) { stationarity_[j] += engine_.qp.rows[e] * lambda_[i]; });
  for (int i = 0; i < m_; ++i)
    if (row_kind_[i] == Row::inequality) stationarity_[n_ + i] -= lambda_[i];
}

// Largest scaled residual of the equations of the barrier problem.
double BarrierRun::error(double mu) const {
  double stationarity = 0.0, product = 0.0, multipliers = 0.0;
  int sides = 0;
  for (int i = 0; i < n_ + m_; ++i) {
    const bool is_fixed = i < n_ && program_.lower()[i] == program_.upper()[i];
    if (!is_fixed) stationarity = std::max(stationarity, std::abs(stationarity_[i]));
    if (lower_[i] > -infinity) {
      product = std::max(product, std::abs(z_lower_[i] * (now_.x[i] - lower_[i]) - mu));
      ++sides;
    }
    if (upper_[i] < infinity) {
      product = std::max(product, std::abs(z_upper_[i] * (upper_[i] - now_.x[i]) - mu));
      ++sides;
    }
    multipliers += z_lower_[i] + z_upper_[i];
  }
  const auto unit = [](double sum, int count) {
    return std::max(multiplier_unit, sum / std::max(1, count)) / multiplier_unit;
  };
  return std::max({stationarity / unit(multipliers + lambda_.lpNorm<1>(), n_ + m_ + sides),
                   product / unit(multipliers, sides), largest(now_.rows)});
}

// Slope of the barrier terms of one variable.
double BarrierRun::barrier_slope(int i) const {
  const bool has_lower = lower_[i] > -infinity, has_upper = upper_[i] < infinity;
  double slope = 0.0;
  if (has_lower) slope -= mu_ / (now_.x[i] - lower_[i]);
  if (has_upper) slope += mu_ / (upper_[i] - now_.x[i]);
  if (has_lower && !has_upper) slope += damping * mu_;
  if (has_upper && !has_lower) slope -= damping * mu_;
  return slope;
}

bool BarrierRun::compute_step(const VectorXd& rows) {
  qp::SparseQp& qp = engine_.qp;
  if (!program_.hessian(now_.x.data(), 1.0, lambda_.data(), engine_.hessian.data(), curvature_)) {
    evaluation_failed_ = true;
    return false;
  }
  qp.hessian.setZero();
  for (std::size_t e = 0; e < engine_.position.size(); ++e)
    qp.hessian[engine_.position[e]] = engine_.hessian[e];
  for (int i = 0; i < n_ + m_; ++i) {
    double weight = 0.0;
    if (lower_[i] > -infinity) weight += z_lower_[i] / (now_.x[i] - lower_[i]);
    if (upper_[i] < infinity) weight += z_upper_[i] / (upper_[i] - now_.x[i]);
    if (i < n_)
      weights_[i] = weight;
    else
      row_weights_[i - n_] = weight;
    if (i >= n_ && row_kind_[i - n_] == Row::equality) row_weights_[i - n_] = infinity;
  }
  if (!step_.factor(qp, weights_, row_weights_, mu_)) return false;
  if (!solve_or_correct(rows)) return false;
  // Rows that cannot be satisfied within the bounds drive the multipliers to infinity while the
  // bounds shorten the steps to zero. Shifted rows keep the multipliers finite.
  const bool is_driven =
      largest(dlambda_) > excessive_multiplier && longest_step(now_.x, dx_) < useful_step;
  if (is_driven && step_.row_shift() == 0.0 && !(step_.shift_rows() && solve_or_correct(rows)))
    return false;
  for (int i = 0; i < n_ + m_; ++i) {
    dz_lower_[i] = dz_upper_[i] = 0.0;
    if (lower_[i] > -infinity) {
      const double d = now_.x[i] - lower_[i];
      dz_lower_[i] = (mu_ - z_lower_[i] * dx_[i]) / d - z_lower_[i];
    }
    if (upper_[i] < infinity) {
      const double d = upper_[i] - now_.x[i];
      dz_upper_[i] = (mu_ + z_upper_[i] * dx_[i]) / d - z_upper_[i];
    }
  }
  return true;
}

// Computes the step, with larger shifts if its accuracy requires them.
bool BarrierRun::solve_or_correct(const VectorXd& rows) {
  while (!solve_step(rows, dx_, dlambda_))
    if (!step_.correct()) return false;
  return true;
}

// Newton's step for these residuals of the rows.
bool BarrierRun::solve_step(const VectorXd& rows, VectorXd& dx, VectorXd& dlambda) {
  for (int i = 0; i < n_; ++i)
    rw_[i] = stationarity_[i] + z_lower_[i] - z_upper_[i] + barrier_slope(i);
  for (int i = 0; i < m_; ++i) {
    rr_[i] = rows[i];
    if (row_kind_[i] != Row::inequality) continue;
    rs_[i] = barrier_slope(n_ + i) - lambda_[i];
    rr_[i] += rs_[i] / (row_weights_[i] + step_.shift());
  }
  if (!step_.solve(rw_, rr_, weights_work_, dlambda)) return false;
  dx.head(n_) = weights_work_;
  for (int i = 0; i < m_; ++i)
    dx[n_ + i] = row_kind_[i] == Row::inequality
                     ? (dlambda[i] - rs_[i]) / (row_weights_[i] + step_.shift())
                     : 0.0;
  return dx.allFinite() && dlambda.allFinite();
}

}  // namespace saltus
