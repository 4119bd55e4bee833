// Step length: the filter, second-order corrections, the watchdog, longer steps.
#include "saltus/solver/barrier_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/solver/barrier_numbers.hpp"

namespace saltus {
namespace {

using barrier::epsilon;

// Largest ratio of z to mu / distance, and of its inverse.
constexpr double multiplier_range = 1e10;
// Filter and line search constants.
constexpr double violation_margin = 1e-5, cost_margin = 1e-8, armijo = 1e-8;
constexpr double switch_factor = 1.0, switch_violation = 1.1, switch_cost = 2.3;
constexpr double least_alpha = 0.05;
constexpr double largest_increase = 5.0;  // limit for the barrier cost, in powers of ten
constexpr int corrections = 4;
constexpr double worthwhile_correction = 0.99;
// Number of times a step may be doubled, and the allowed growth of the violation.
constexpr int doublings = 10;
constexpr double more_violation = 4.0;
constexpr double tiny_step = 10.0 * epsilon;

// a <= b up to rounding errors of numbers of the size of `unit`.
bool at_most(double a, double b, double unit) { return a - b <= 10.0 * epsilon * std::abs(unit); }

}  // namespace

double BarrierRun::longest_step(const VectorXd& x, const VectorXd& dx, double most) const {
  double alpha = most;
  for (int i = 0; i < n_ + m_; ++i) {
    if (lower_[i] > -infinity && dx[i] < 0.0)
      alpha = std::min(alpha, -tau_ * (x[i] - lower_[i]) / dx[i]);
    if (upper_[i] < infinity && dx[i] > 0.0)
      alpha = std::min(alpha, tau_ * (upper_[i] - x[i]) / dx[i]);
  }
  return alpha;
}

double BarrierRun::longest_dual_step() const {
  double alpha = 1.0;
  for (int i = 0; i < n_ + m_; ++i) {
    if (dz_lower_[i] < 0.0) alpha = std::min(alpha, -tau_ * z_lower_[i] / dz_lower_[i]);
    if (dz_upper_[i] < 0.0) alpha = std::min(alpha, -tau_ * z_upper_[i] / dz_upper_[i]);
  }
  return alpha;
}

double BarrierRun::slope() const {
  double sum = gradient_.dot(dx_.head(n_));
  for (int i = 0; i < n_ + m_; ++i) sum += barrier_slope(i) * dx_[i];
  return sum;
}

bool BarrierRun::is_cost_step(const Reference& from, double alpha) const {
  return from.slope < 0.0 && alpha * std::pow(-from.slope, switch_cost) >
                                 switch_factor * std::pow(from.violation, switch_violation);
}

bool BarrierRun::has_sufficient_decrease(const Reference& from, const Trial& trial,
                                         double alpha) const {
  return at_most(trial.barrier_cost - from.barrier_cost, armijo * alpha * from.slope,
                 from.barrier_cost);
}

bool BarrierRun::is_acceptable(const Reference& from, const Trial& trial, double alpha) const {
  const double increase = trial.barrier_cost - from.barrier_cost;
  if (increase > 0.0 &&
      std::log10(increase) >
          largest_increase + std::max(1.0, std::log10(std::abs(from.barrier_cost) + 1e-300)))
    return false;
  if (trial.violation > largest_violation_) return false;
  if (alpha > 0.0 && is_cost_step(from, alpha) && from.violation <= least_violation_) {
    if (!has_sufficient_decrease(from, trial, alpha)) return false;
  } else {
    const bool nearer =
        at_most(trial.violation, (1.0 - violation_margin) * from.violation, from.violation);
    const bool cheaper = at_most(increase, -cost_margin * from.violation, from.barrier_cost);
    if (!nearer && !cheaper) return false;
  }
  return filter_.accepts(trial.violation, trial.barrier_cost);
}

// Returns to the start of the watchdog steps.
void BarrierRun::restore_watchdog() {
  now_ = watch_.now;
  lambda_ = watch_.lambda;
  z_lower_ = watch_.z_lower;
  z_upper_ = watch_.z_upper;
  watch_.active = false;
}

bool BarrierRun::search() {
  Reference from{now_.violation, now_.barrier_cost, slope()};
  double longest = longest_step(now_.x, dx_);
  bool skip_first = false;
  // Detects steps of the size of rounding.
  double size = 0.0;
  for (int i = 0; i < n_ + m_; ++i)
    size = std::max(size, std::abs(dx_[i]) / (1.0 + std::abs(now_.x[i])));
  if (size < tiny_step && now_.violation < 1e-4) {
    trial_.x = now_.x + longest * dx_;
    if (evaluate(trial_)) {
      ++tiny_;
      accept(trial_, longest, 1.0);
      return true;
    }
  }
  tiny_ = 0;
  if (!watch_.active && shortened_ >= watch_after_) {
    watch_ = {true, 0,        now_,      lambda_,   z_lower_, z_upper_,
              dx_,  dlambda_, dz_lower_, dz_upper_, from,     longest};
  }
  if (watch_.active) {
    trial_.x = now_.x + longest * dx_;
    const bool evaluated = evaluate(trial_);
    if (evaluated && is_acceptable(watch_.from, trial_, watch_.longest)) {
      watch_.active = false;
      shortened_ = 0;
      if (!is_cost_step(watch_.from, watch_.longest) ||
          !has_sufficient_decrease(watch_.from, trial_, watch_.longest))
        add_to_filter(watch_.from);
      accept(trial_, longest, longest_dual_step());
      return true;
    }
    if (evaluated && ++watch_.trials <= watch_steps) {
      accept(trial_, longest, longest_dual_step());
      return true;
    }
    // Returns to the start of the watchdog and takes shorter steps from there.
    restore_watchdog();
    dx_ = watch_.dx;
    dlambda_ = watch_.dlambda;
    dz_lower_ = watch_.dz_lower;
    dz_upper_ = watch_.dz_upper;
    from = watch_.from;
    longest = watch_.longest;
    shortened_ = 0;
    skip_first = true;
    if (!linearise()) return false;
    compute_stationarity();
  }

  double least = least_alpha * violation_margin;
  if (from.slope < 0.0) {
    least = std::min(violation_margin, cost_margin * from.violation / -from.slope);
    if (from.violation <= least_violation_)
      least = std::min(least, switch_factor * std::pow(from.violation, switch_violation) /
                                  std::pow(-from.slope, switch_cost));
    least *= least_alpha;
  }
  for (double alpha = skip_first ? 0.5 * longest : longest; alpha >= least || alpha == longest;
       alpha *= 0.5) {
    trial_.x = now_.x + alpha * dx_;
    const bool evaluated = evaluate(trial_);
    if (evaluated && is_acceptable(from, trial_, alpha)) {
      shortened_ = alpha == longest ? 0 : shortened_ + 1;
      if (!is_cost_step(from, alpha) || !has_sufficient_decrease(from, trial_, alpha))
        add_to_filter(from);
      if (alpha == 1.0) lengthen(from);
      accept(trial_, alpha, longest_dual_step());
      return true;
    }
    if (evaluated && alpha == longest && trial_.violation >= from.violation &&
        correct_second_order(from, alpha))
      return true;
  }
  return false;
}

// A shift of the Hessian may make a step far too short, especially where the cost has negative
// curvature. The step is doubled as long as that helps.
void BarrierRun::lengthen(const Reference& from) {
  if (step_.shift() == 0.0 || from.violation > least_violation_) return;
  const double room = longest_step(now_.x, dx_, std::ldexp(1.0, doublings));
  const double most = more_violation * std::max(from.violation, trial_.violation);
  Trial longer = trial_;
  for (double alpha = 2.0; alpha <= room; alpha *= 2.0) {
    longer.x = now_.x + alpha * dx_;
    if (!evaluate(longer) || longer.barrier_cost >= trial_.barrier_cost ||
        longer.violation > most || !is_acceptable(from, longer, 1.0))
      return;
    std::swap(trial_, longer);
  }
}

void BarrierRun::add_to_filter(const Reference& from) {
  filter_.add((1.0 - violation_margin) * from.violation,
              from.barrier_cost - cost_margin * from.violation);
}

// If the curvature of the rows made the full step fail, repeats it with the residuals at its end.
bool BarrierRun::correct_second_order(const Reference& from, double alpha) {
  VectorXd rows = now_.rows, dx = dx_, dlambda = dlambda_;
  double last = trial_.violation, length = alpha;
  for (int round = 0; round < corrections; ++round) {
    rows = length * rows + trial_.rows;
    if (!solve_step(rows, dx, dlambda)) return false;
    length = longest_step(now_.x, dx);
    trial_.x = now_.x + length * dx;
    if (!evaluate(trial_)) return false;
    if (is_acceptable(from, trial_, alpha)) {
      shortened_ = 0;
      if (!is_cost_step(from, alpha) || !has_sufficient_decrease(from, trial_, alpha))
        add_to_filter(from);
      dlambda_ = dlambda;
      accept(trial_, length, longest_dual_step());
      return true;
    }
    if (trial_.violation > worthwhile_correction * last) return false;
    last = trial_.violation;
  }
  return false;
}

void BarrierRun::accept(Trial& trial, double alpha, double dual_alpha) {
  std::swap(now_, trial);
  alpha_ = alpha;
  dual_alpha_ = dual_alpha;
  lambda_ += alpha * dlambda_;
  z_lower_ += dual_alpha * dz_lower_;
  z_upper_ += dual_alpha * dz_upper_;
  relax_bounds();
  // A side may be nearly reached by rounding alone.
  for (int i = 0; i < n_ + m_; ++i) {
    if (lower_[i] > -infinity) {
      const double least = epsilon * std::max(1.0, std::abs(lower_[i]));
      now_.x[i] = std::max(now_.x[i], lower_[i] + least);
      const double central = mu_ / (now_.x[i] - lower_[i]);
      z_lower_[i] = std::clamp(z_lower_[i], central / multiplier_range, central * multiplier_range);
    }
    if (upper_[i] < infinity) {
      const double least = epsilon * std::max(1.0, std::abs(upper_[i]));
      now_.x[i] = std::min(now_.x[i], upper_[i] - least);
      const double central = mu_ / (upper_[i] - now_.x[i]);
      z_upper_[i] = std::clamp(z_upper_[i], central / multiplier_range, central * multiplier_range);
    }
  }
}

}  // namespace saltus
