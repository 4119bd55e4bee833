// Restoration: finds a point with a smaller violation if no step is accepted.
#include "saltus/solver/barrier_run.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "saltus/qp/sparse_newton.hpp"
#include "saltus/solver/barrier_numbers.hpp"

namespace saltus {
namespace {

using barrier::epsilon;
using barrier::largest;
using barrier::largest_estimate;

constexpr double restored = 0.9;  // largest remaining fraction of the violation

}  // namespace

// Finds a point with a smaller violation that the filter accepts; returns optimal on success.
SolveStatus BarrierRun::restore() {
  if (watch_.active) restore_watchdog();
  shortened_ = 0;
  if (!options_.can_restore || largest(now_.rows) <= options_.tolerance)
    return SolveStatus::numerical_failure;
  const Reference from{now_.violation, now_.barrier_cost, -1.0};
  add_to_filter(from);

  RestorationProgram relaxed(program_);
  relaxed.restart(now_.x.head(n_), std::sqrt(mu_));
  if (engine_.restoration == nullptr)
    engine_.restoration = std::make_unique<BarrierEngine>(
        relaxed,
        qp::make_sparse_newton(BarrierEngine::full_hessian(relaxed), relaxed.jacobian_pattern()));
  BarrierOptions options = options_;
  options.first_barrier = std::max(mu_, largest(now_.rows));
  options.can_restore = false;
  options.is_central = true;
  options.push = 1e-8;
  options.max_iterations = options_.max_iterations - iterations_;
  options.first_number = options_.first_number + iterations_;
  options.suffices = [&](const VectorXd& w, const VectorXd& slacks) {
    trial_.x.head(n_) = w.head(n_);  // without the variables of the relaxation
    for (int i = 0; i < m_; ++i)
      trial_.x[n_ + i] = row_kind_[i] == Row::inequality ? slacks[i] : 0.0;
    keep_inside(trial_.x);
    return evaluate(trial_) && trial_.violation <= restored * from.violation &&
           is_acceptable(from, trial_, 0.0);
  };
  NlpPoint start;
  start.w = VectorXd::Zero(relaxed.variables());
  start.w.head(n_) = now_.x.head(n_);
  const double mu = options.first_barrier, rho = RestorationProgram::weight;
  for (int i = 0; i < m_; ++i) {
    const double c = now_.rows[i], half = (mu - rho * c) / (2.0 * rho);
    const double below = half + std::sqrt(half * half + mu * c / (2.0 * rho));
    start.w[n_ + m_ + i] = below;
    start.w[n_ + i] = c + below;
  }
  BarrierRun run(relaxed, curvature_, *engine_.restoration, options);
  const SolveStatus status = run.solve(start);
  iterations_ += run.iterations();
  const NlpPoint end = run.point();
  if (end.w.size() != relaxed.variables()) return SolveStatus::evaluation_failed;
  trial_.x.head(n_) = end.w.head(n_);
  for (int i = 0; i < m_; ++i)
    trial_.x[n_ + i] = row_kind_[i] == Row::inequality ? run.slacks()[i] : 0.0;
  keep_inside(trial_.x);
  const bool ended = status == SolveStatus::optimal || status == SolveStatus::acceptable;
  if (!evaluate(trial_)) return ended ? SolveStatus::evaluation_failed : status;
  const bool feasible = largest(trial_.rows) <= options_.tolerance;
  if (ended) {
    const bool accepted = trial_.violation <= restored * from.violation;
    std::swap(now_, trial_);
    if (!accepted && !feasible) {
      lambda_ = end.lambda;  // multipliers of the least violation, for the contradiction
      compute_stationarity();
      return SolveStatus::infeasible;
    }
    relax_bounds();
    for (int i = 0; i < n_ + m_; ++i) {
      if (lower_[i] > -infinity)
        z_lower_[i] = std::min(mu_ / (now_.x[i] - lower_[i]), largest_estimate);
      if (upper_[i] < infinity)
        z_upper_[i] = std::min(mu_ / (upper_[i] - now_.x[i]), largest_estimate);
    }
    was_restored_ = true;
    return SolveStatus::optimal;
  }
  std::swap(now_, trial_);
  return status;
}

// The restoration has wider sides and a larger barrier parameter.
void BarrierRun::keep_inside(VectorXd& x) const {
  for (int i = 0; i < n_ + m_; ++i) {
    const double l = lower_[i], u = upper_[i];
    if (l > -infinity) x[i] = std::max(x[i], l + epsilon * std::max(1.0, std::abs(l)));
    if (u < infinity) x[i] = std::min(x[i], u - epsilon * std::max(1.0, std::abs(u)));
  }
}

}  // namespace saltus
