#include "saltus/solver/barrier_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "saltus/qp/sparse_newton.hpp"
#include "saltus/solver/convexify.hpp"

namespace saltus {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
// The start: multipliers of the sides, largest ones of the rows.
constexpr double first_multiplier = 1.0, largest_estimate = 1e3;
// Those of rows whose slopes are 100 at most that deserve a look, and what replaces them.
constexpr double excessive_multiplier = 1e4, much_smaller = 1e-2;
// Barrier parameter: solved to this multiple of it, then times the first, or to the power of the
// second.
constexpr double barrier_error = 10.0, barrier_factor = 0.2, barrier_power = 1.5;
constexpr double least_fraction = 0.99;    // of the way to a side
constexpr double multiplier_range = 1e10;  // of z around mu / distance
// Room that inequality rows get, times mu.
constexpr double row_room = 1e-2, kept_room = 0.1;
// Variables with one side only: a slope that keeps them from running away, times mu.
constexpr double damping = 1e-5;
// Filter and line search.
constexpr double violation_margin = 1e-5, cost_margin = 1e-8, armijo = 1e-8;
constexpr double switch_factor = 1.0, switch_violation = 1.1, switch_cost = 2.3;
constexpr double least_alpha = 0.05;
constexpr double largest_violation = 1e4, small_violation = 1e-4;
constexpr double largest_increase = 5.0;  // of the barrier cost, powers of ten
constexpr int corrections = 4;
constexpr double worthwhile_correction = 0.99;
// How often a step may be doubled, and how much that may add to the violation.
constexpr int doublings = 10;
constexpr double more_violation = 4.0;
constexpr double tiny_step = 10.0 * epsilon;
// Progress has stopped where the looser tolerance was met this often in a row.
constexpr double acceptable_factor = 100.0, acceptable_at_failure = 1e3;
constexpr int acceptable_points = 15;
constexpr double multiplier_unit = 100.0;  // multipliers up to this size need no scaling
constexpr double unbounded_cost = -1e20, far = 1e20;
constexpr double restored = 0.9;  // of the violation, at most

double largest(const VectorXd& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

// a <= b but for the rounding of numbers of the size of `unit`.
bool at_most(double a, double b, double unit) { return a - b <= 10.0 * epsilon * std::abs(unit); }

}  // namespace

SparsityPattern BarrierEngine::full_hessian(const NonlinearProgram& program) {
  return with_diagonal(program.hessian_pattern());
}

BarrierEngine::BarrierEngine(const NonlinearProgram& program, std::unique_ptr<NewtonSystem> system)
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
  NlpPoint point{now_.x.head(n_), lambda_, (z_upper_ - z_lower_).head(n_)};
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

// --- start --------------------------------------------------------------------------------------

bool BarrierRun::begin(const NlpPoint& start) {
  SparseQp& qp = engine_.qp;
  qp.lower = program_.lower();
  qp.upper = program_.upper();
  qp.row_lower = program_.row_lower();
  qp.row_upper = program_.row_upper();
  lower_ = VectorXd::Constant(n_ + m_, -infinity);
  upper_ = VectorXd::Constant(n_ + m_, infinity);
  for (int i = 0; i < n_; ++i)
    if (qp.lower[i] < qp.upper[i]) {
      lower_[i] = qp.lower[i];
      upper_[i] = qp.upper[i];
    }
  for (int i = 0; i < m_; ++i) {
    const double l = qp.row_lower[i], u = qp.row_upper[i];
    row_kind_[i] = l == u                          ? Row::equality
                   : l > -infinity || u < infinity ? Row::inequality
                                                   : Row::free;
  }
  mu_ = options_.first_barrier;
  tau_ = std::max(least_fraction, 1.0 - mu_);
  relax_rows();
  for (Trial* t : {&now_, &trial_}) {
    t->x = VectorXd::Zero(n_ + m_);
    t->rows = VectorXd::Zero(m_);
  }
  gradient_ = VectorXd::Zero(n_);
  stationarity_ = VectorXd::Zero(n_ + m_);
  for (VectorXd* v : {&dx_, &dz_lower_, &dz_upper_, &z_lower_, &z_upper_})
    *v = VectorXd::Zero(n_ + m_);
  for (VectorXd* v : {&lambda_, &dlambda_, &row_weights_, &rr_, &rs_}) *v = VectorXd::Zero(m_);
  weights_ = weights_work_ = rw_ = VectorXd::Zero(n_);

  now_.x.head(n_) = start.w.cwiseMax(program_.lower()).cwiseMin(program_.upper());
  push_inside(0, n_, now_.x);
  if (!program_.constraints(now_.x.data(), rr_.data()) || !rr_.allFinite()) return false;
  for (int i = 0; i < m_; ++i)
    if (row_kind_[i] == Row::inequality) now_.x[n_ + i] = rr_[i];
  push_inside(n_, n_ + m_, now_.x);
  for (int i = 0; i < n_ + m_; ++i) {
    const auto multiplier = [&](double distance) {
      return options_.is_central ? mu_ / distance : first_multiplier;
    };
    if (lower_[i] > -infinity) z_lower_[i] = multiplier(now_.x[i] - lower_[i]);
    if (upper_[i] < infinity) z_upper_[i] = multiplier(upper_[i] - now_.x[i]);
  }
  if (!evaluate(now_) || !linearise()) return false;
  if (!options_.is_central) lambda_ = estimate_multipliers(largest_estimate);
  compute_stationarity();
  least_violation_ = small_violation * std::max(1.0, now_.violation);
  largest_violation_ = largest_violation * std::max(1.0, now_.violation);
  filter_.reset(largest_violation_);
  return true;
}

// Inequalities that equalities leave no room, such as a bound on what is given where a phase ends,
// have none between their sides and no multipliers that balance: they get room that vanishes with
// mu.
void BarrierRun::relax_rows() {
  for (int i = 0; i < m_; ++i) {
    if (row_kind_[i] != Row::inequality) continue;
    const double l = program_.row_lower()[i], u = program_.row_upper()[i];
    lower_[n_ + i] = l - row_room * mu_ * std::max(1.0, std::abs(l));
    upper_[n_ + i] = u + row_room * mu_ * std::max(1.0, std::abs(u));
  }
}

void BarrierRun::push_inside(int first, int last, VectorXd& x) const {
  for (int i = first; i < last; ++i) {
    const double l = lower_[i], u = upper_[i];
    if (l > -infinity)
      x[i] = std::max(
          x[i], l + std::min(options_.push * std::max(1.0, std::abs(l)), options_.push * (u - l)));
    if (u < infinity)
      x[i] = std::min(
          x[i], u - std::min(options_.push * std::max(1.0, std::abs(u)), options_.push * (u - l)));
  }
}

// Those of the rows with which stationarity holds best, |grad f + J'lambda + z| least; none if they
// are larger than that.
VectorXd BarrierRun::estimate_multipliers(double most) {
  SparseQp& qp = engine_.qp;
  const VectorXd hessian = qp.hessian;
  qp.hessian.setZero();
  weights_.setOnes();
  rw_ = gradient_ + (z_upper_ - z_lower_).head(n_);
  for (int i = 0; i < m_; ++i) {
    row_weights_[i] = row_kind_[i] == Row::equality     ? infinity
                      : row_kind_[i] == Row::inequality ? 1.0
                                                        : 0.0;
    rr_[i] = row_kind_[i] == Row::inequality ? z_upper_[n_ + i] - z_lower_[n_ + i] : 0.0;
  }
  VectorXd ignored = VectorXd::Zero(n_);
  const bool solved =
      step_.factor(qp, weights_, row_weights_, mu_) && step_.solve(rw_, rr_, ignored, dlambda_);
  qp.hessian = hessian;
  if (!solved || largest(dlambda_) > most) return VectorXd::Zero(m_);
  VectorXd estimate = dlambda_;
  for (int i = 0; i < m_; ++i)
    if (row_kind_[i] == Row::free) estimate[i] = 0.0;
  return estimate;
}

// Rows that nearly depend on one another let multipliers grow against each other, and with them the
// Hessian. Those that serve as well are taken, if they are much smaller.
void BarrierRun::shrink_multipliers() {
  const VectorXd estimate = estimate_multipliers(much_smaller * largest(lambda_));
  if (largest(estimate) > 0.0) lambda_ = estimate;
}

// --- evaluation ---------------------------------------------------------------------------------

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

// False where the program cannot be evaluated.
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

// --- iteration ----------------------------------------------------------------------------------

SolveStatus BarrierRun::solve(const NlpPoint& start) {
  if (!begin(start)) {
    if (stationarity_.size() == 0) stationarity_ = VectorXd::Zero(n_ + m_);
    return SolveStatus::evaluation_failed;
  }
  for (;; ++iterations_) {
    const double least = error(0.0);
    if (options_.report) options_.report(*this);
    if (least <= options_.tolerance) return SolveStatus::optimal;
    acceptable_ = least <= acceptable_factor * options_.tolerance ? acceptable_ + 1 : 0;
    if (acceptable_ >= acceptable_points) return SolveStatus::acceptable;
    if (now_.cost < unbounded_cost || largest(now_.x) > far) return SolveStatus::unbounded;
    if (timed_out()) return SolveStatus::time_limit;
    if (iterations_ >= options_.max_iterations) return SolveStatus::iteration_limit;
    const auto give_up = [&](SolveStatus status) {
      return error(0.0) <= acceptable_at_failure * options_.tolerance ? SolveStatus::acceptable
                                                                      : status;
    };
    lower_barrier();
    const bool has_step = compute_step(now_.rows);
    if (evaluation_failed_) return SolveStatus::evaluation_failed;
    if (!has_step || !search()) {
      const SolveStatus status = restore();
      if (status != SolveStatus::optimal) return give_up(status);
    }
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
  for (int i = n_; i < n_ + m_; ++i) {  // as near to the side as before, at most
    const double to_lower = now_.x[i] - lower[i], to_upper = upper[i] - now_.x[i];
    if (lower_[i] > -infinity && now_.x[i] - lower_[i] < kept_room * to_lower)
      now_.x[i] = lower_[i] + kept_room * to_lower;
    if (upper_[i] < infinity && upper_[i] - now_.x[i] < kept_room * to_upper)
      now_.x[i] = upper_[i] - kept_room * to_upper;
  }
  evaluate(now_);
  tiny_ = 0;
  tau_ = std::max(least_fraction, 1.0 - mu_);
  filter_.reset(largest_violation_);
  watch_.active = false;
  shortened_ = 0;
  now_.barrier_cost = barrier_cost(now_.x, now_.cost);
}

// Slope of the barrier's terms of one variable.
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
  SparseQp& qp = engine_.qp;
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
  while (!solve_step(rows, dx_, dlambda_))
    if (!step_.correct()) return false;
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

// --- line search --------------------------------------------------------------------------------

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

bool BarrierRun::falls_enough(const Reference& from, const Trial& trial, double alpha) const {
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
    if (!falls_enough(from, trial, alpha)) return false;
  } else {
    const bool nearer =
        at_most(trial.violation, (1.0 - violation_margin) * from.violation, from.violation);
    const bool cheaper = at_most(increase, -cost_margin * from.violation, from.barrier_cost);
    if (!nearer && !cheaper) return false;
  }
  return filter_.accepts(trial.violation, trial.barrier_cost);
}

bool BarrierRun::search() {
  Reference from{now_.violation, now_.barrier_cost, slope()};
  double longest = longest_step(now_.x, dx_);
  bool skip_first = false;
  // Steps that are nothing but rounding.
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
          !falls_enough(watch_.from, trial_, watch_.longest))
        add_to_filter(watch_.from);
      accept(trial_, longest, longest_dual_step());
      return true;
    }
    if (evaluated && ++watch_.trials <= watch_steps) {
      accept(trial_, longest, longest_dual_step());
      return true;
    }
    // Back to where the watch began, and shorter steps from there.
    now_ = watch_.now;
    lambda_ = watch_.lambda;
    z_lower_ = watch_.z_lower;
    z_upper_ = watch_.z_upper;
    dx_ = watch_.dx;
    dlambda_ = watch_.dlambda;
    dz_lower_ = watch_.dz_lower;
    dz_upper_ = watch_.dz_upper;
    from = watch_.from;
    longest = watch_.longest;
    watch_.active = false;
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
      if (!is_cost_step(from, alpha) || !falls_enough(from, trial_, alpha)) add_to_filter(from);
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

// A step shortened by a shift of the Hessian may be far too short, above all where the cost curves
// downward: it is doubled as long as that pays.
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

// The curvature of the rows made the full step fail: its residuals are taken into account.
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
      if (!is_cost_step(from, alpha) || !falls_enough(from, trial_, alpha)) add_to_filter(from);
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
  // A side that is nearly met may be so by rounding alone.
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

// --- restoration --------------------------------------------------------------------------------

// A point nearer to the rows that the filter accepts; optimal: it was found.
SolveStatus BarrierRun::restore() {
  if (watch_.active) {
    now_ = watch_.now;
    lambda_ = watch_.lambda;
    z_lower_ = watch_.z_lower;
    z_upper_ = watch_.z_upper;
    watch_.active = false;
  }
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
        make_sparse_newton(BarrierEngine::full_hessian(relaxed), relaxed.jacobian_pattern()));
  BarrierOptions options = options_;
  options.first_barrier = std::max(mu_, largest(now_.rows));
  options.can_restore = false;
  options.is_central = true;
  options.push = 1e-8;
  options.max_iterations = options_.max_iterations - iterations_;
  options.suffices = [&](const VectorXd& w, const VectorXd& slacks) {
    trial_.x.head(n_) = w;
    for (int i = 0; i < m_; ++i)
      trial_.x[n_ + i] = row_kind_[i] == Row::inequality ? slacks[i] : 0.0;
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
  if (!evaluate(trial_)) return SolveStatus::evaluation_failed;
  const bool feasible = largest(trial_.rows) <= options_.tolerance;
  if (status == SolveStatus::optimal || status == SolveStatus::acceptable) {
    const bool accepted = trial_.violation <= restored * from.violation;
    std::swap(now_, trial_);
    if (!accepted && !feasible) {
      lambda_ = end.lambda;  // of what contradicts: those of the least violation
      compute_stationarity();
      return SolveStatus::infeasible;
    }
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

}  // namespace saltus
