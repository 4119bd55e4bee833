// Main loop of a run: step, barrier update, termination.
#include "saltus/solver/barrier_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "saltus/solver/barrier_numbers.hpp"
#include "saltus/solver/convexify.hpp"
#include "saltus/solver/verdict.hpp"

namespace saltus {
namespace {

using barrier::excessive_multiplier;
using barrier::kept_room;
using barrier::largest;
using barrier::largest_estimate;
using barrier::least_fraction;

// The barrier problem is solved to this multiple of mu. Then mu is multiplied by the factor or
// raised to the power.
constexpr double barrier_error = 10.0, barrier_factor = 0.2, barrier_power = 1.5;
// The run stops with `acceptable` after this many consecutive points that meet the looser
// tolerance.
constexpr double acceptable_factor = acceptable_multiple, acceptable_at_failure = 1e3;
constexpr int acceptable_points = 15;
// number of iterations away from an acceptable point before the run stops
constexpr int patience_with_best = 50;
constexpr double unbounded_cost = -1e20, far = 1e20;

}  // namespace

SparsityPattern BarrierEngine::full_hessian(const NonlinearProgram& program) {
  return with_diagonal(program.hessian_pattern());
}

BarrierEngine::BarrierEngine(const NonlinearProgram& program,
                             std::unique_ptr<qp::NewtonSystem> system)
    : qp(full_hessian(program), program.jacobian_pattern()),
      hessian(program.hessian_pattern().entries()),
      newton(std::move(system)) {
  program.hessian_pattern().for_each(
      [&](int r, int c, int) { position.push_back(qp.hessian_pattern.find(r, c)); });
}

BarrierRun::BarrierRun(NonlinearProgram& program, Curvature curvature, BarrierEngine& engine,
                       BarrierOptions options)
    : program_(program),
      curvature_(curvature),
      engine_(engine),
      options_(std::move(options)),
      step_(*engine.newton, program.variables(), program.rows()),
      n_(program.variables()),
      m_(program.rows()),
      row_kind_(m_, Row::inequality) {}

NlpPoint BarrierRun::point() const {
  NlpPoint point{now_.x.head(n_).cwiseMax(program_.lower()).cwiseMin(program_.upper()), lambda_,
                 (z_upper_ - z_lower_).head(n_)};
  for (int i = 0; i < n_; ++i)
    if (program_.lower()[i] == program_.upper()[i]) point.z[i] = -stationarity_[i];
  return point;
}

std::string BarrierRun::describe() const {
  char line[200];
  std::snprintf(line, sizeof line,
                "%4d f %.10e viol %.2e err %.2e mu %.1e |d| %.1e shift %.1e/%.0e alpha %.1e %.1e "
                "|l| %.1e |dl| %.1e acc %.1e",
                iterations_, now_.cost, largest(now_.rows), error(0.0), mu_, largest(dx_),
                step_.shift(), step_.row_shift(), alpha_, dual_alpha_, largest(lambda_),
                largest(dlambda_), step_.accuracy());
  return line;
}

SolveObserver::Iteration BarrierRun::iteration() const {
  return {.number = options_.first_number + iterations_,
          .is_restoring = !options_.can_restore,
          .cost = now_.cost,
          .violation = largest(now_.rows),
          .stationarity = largest(stationarity_),
          .barrier = mu_,
          .step = largest(dx_),
          .regularisation = step_.shift(),
          .step_length = alpha_,
          .dual_step_length = dual_alpha_};
}

SolveStatus BarrierRun::solve(const NlpPoint& start) {
  if (!begin(start)) {
    if (stationarity_.size() == 0) stationarity_ = VectorXd::Zero(n_ + m_);
    return SolveStatus::evaluation_failed;
  }
  for (;; ++iterations_) {
    const double least = error(0.0);
    if (options_.report) options_.report(*this);
    if (options_.observer != nullptr && options_.observer->report)
      options_.observer->report(iteration());
    if (least <= options_.tolerance) return SolveStatus::optimal;
    acceptable_ = least <= acceptable_factor * options_.tolerance ? acceptable_ + 1 : 0;
    if (acceptable_ >= acceptable_points) return SolveStatus::acceptable;
    if (now_.cost < unbounded_cost || largest(now_.x) > far) return SolveStatus::unbounded;
    if (timed_out()) return SolveStatus::time_limit;
    if (options_.observer != nullptr && options_.observer->wants_stop())
      return SolveStatus::interrupted;
    if (least <= acceptable_at_failure * options_.tolerance && !(best_.error <= least)) keep(least);
    const auto give_up = [&](SolveStatus status) {
      return return_to_best() ? SolveStatus::acceptable : status;
    };
    if (iterations_ >= options_.max_iterations) return give_up(SolveStatus::iteration_limit);
    if (best_.error < infinity && iterations_ - best_.iteration >= patience_with_best)
      return give_up(SolveStatus::numerical_failure);
    if (options_.can_restore && largest(now_.rows) > options_.tolerance &&
        cycle_.is_cycling(now_.cost, now_.violation))
      return give_up(SolveStatus::numerical_failure);
    lower_barrier();
    const bool has_step = !evaluation_failed_ && compute_step(now_.rows);
    if (evaluation_failed_) return SolveStatus::evaluation_failed;
    if (!has_step || !search()) {
      const SolveStatus status = restore();
      if (status != SolveStatus::optimal) return give_up(status);
    }
    if (!was_restored_ && largest(lambda_) <= excessive_multiplier)
      program_.prepare_derivatives(now_.x.data(), 1.0, lambda_.data(), curvature_);
    if (!linearise()) return SolveStatus::evaluation_failed;
    if (was_restored_) lambda_ = estimate_multipliers(largest_estimate);
    if (largest(lambda_) > excessive_multiplier) shrink_multipliers();
    was_restored_ = false;
    compute_stationarity();
    if (options_.suffices && options_.suffices(now_.x.head(n_), now_.x.tail(m_)))
      return SolveStatus::optimal;
    if (tiny_ >= 2 && mu_ <= least_barrier()) return give_up(SolveStatus::numerical_failure);
  }
}

void BarrierRun::keep(double error) {
  best_ = {error, iterations_, now_, lambda_, z_lower_, z_upper_, stationarity_};
}

// Close to an optimum with dependent rows, steps may lose accuracy and move away from it. Returns
// false if no iterate was good enough.
bool BarrierRun::return_to_best() {
  const double last = error(0.0);
  if (last <= acceptable_at_failure * options_.tolerance && !(best_.error <= last)) return true;
  if (best_.error == infinity) return false;
  now_ = best_.now;
  lambda_ = best_.lambda;
  z_lower_ = best_.z_lower;
  z_upper_ = best_.z_upper;
  stationarity_ = best_.stationarity;
  return true;
}

double BarrierRun::least_barrier() const { return options_.tolerance / (barrier_error + 1.0); }

void BarrierRun::lower_barrier() {
  bool lowered = false;
  while (mu_ > least_barrier() && (error(mu_) <= barrier_error * mu_ || (tiny_ > 0 && !lowered))) {
    mu_ = std::max(least_barrier(), std::min(barrier_factor * mu_, std::pow(mu_, barrier_power)));
    lowered = true;
  }
  if (!lowered) return;
  const VectorXd lower = lower_, upper = upper_;
  relax_rows();
  for (int i = n_; i < n_ + m_; ++i) {  // at most as close to the side as before
    const double to_lower = now_.x[i] - lower[i], to_upper = upper[i] - now_.x[i];
    if (lower_[i] > -infinity && now_.x[i] - lower_[i] < kept_room * to_lower)
      now_.x[i] = lower_[i] + kept_room * to_lower;
    if (upper_[i] < infinity && upper_[i] - now_.x[i] < kept_room * to_upper)
      now_.x[i] = upper_[i] - kept_room * to_upper;
  }
  const bool has_moved = tighten_bounds();
  keep_inside(now_.x);  // in spite of rounding
  if (!evaluate(now_) || (has_moved && !linearise())) evaluation_failed_ = true;
  if (has_moved) compute_stationarity();
  tiny_ = 0;
  cycle_.restart();
  tau_ = std::max(least_fraction, 1.0 - mu_);
  filter_.reset(largest_violation_);
  watch_.active = false;
  shortened_ = 0;
  now_.barrier_cost = barrier_cost(now_.x, now_.cost);
}

}  // namespace saltus
