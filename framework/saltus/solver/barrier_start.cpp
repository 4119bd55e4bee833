// Start of a run: strictly inside all sides, with matching multipliers.
#include "saltus/solver/barrier_run.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/solver/barrier_numbers.hpp"

namespace saltus {
namespace {

using barrier::kept_room;
using barrier::largest;
using barrier::largest_estimate;
using barrier::least_fraction;

constexpr double first_multiplier = 1.0;  // for all sides
constexpr double much_smaller = 1e-2;     // required ratio to the replaced multipliers
// Relaxation of inequality rows, times mu.
constexpr double row_room = 1e-2;
// The same for bounds of variables; for narrow boxes this fraction of their width.
constexpr double bound_room = 1e-3;
constexpr double largest_violation = 1e4, small_violation = 1e-4;  // relative to the start

}  // namespace

bool BarrierRun::begin(const NlpPoint& start) {
  qp::SparseQp& qp = engine_.qp;
  engine_.newton->restart();
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

// Equalities may leave an inequality no interior, for example a bound on a value that is given at
// the end of a phase. Such an inequality has no balanced multipliers. It is relaxed by a distance
// that vanishes with mu.
void BarrierRun::relax_rows() {
  for (int i = 0; i < m_; ++i) {
    if (row_kind_[i] != Row::inequality) continue;
    const double l = program_.row_lower()[i], u = program_.row_upper()[i];
    lower_[n_ + i] = l - row_room * mu_ * std::max(1.0, std::abs(l));
    upper_[n_ + i] = u + row_room * mu_ * std::max(1.0, std::abs(u));
  }
}

// Largest relaxation of the bound of a variable.
double BarrierRun::bound_room_of(int i, double bound) const {
  return bound_room *
         std::min(mu_ * std::max(1.0, std::abs(bound)), program_.upper()[i] - program_.lower()[i]);
}

// Equalities may leave a variable no interior within its bounds, such as a state that starts or
// ends on a bound. Newton's steps then lead onto the bound, and its multiplier grows without limit.
// A bound that the iterate nearly reaches is relaxed by a distance that vanishes with mu.
void BarrierRun::relax_bounds() {
  bool has_moved = false;
  for (int i = 0; i < n_; ++i) {
    const double l = program_.lower()[i], u = program_.upper()[i];
    if (const double side = std::max(now_.x[i], l) - bound_room_of(i, l);
        lower_[i] > -infinity && lower_[i] > side) {
      lower_[i] = side;
      has_moved = true;
    }
    if (const double side = std::min(now_.x[i], u) + bound_room_of(i, u);
        upper_[i] < infinity && upper_[i] < side) {
      upper_[i] = side;
      has_moved = true;
    }
  }
  if (has_moved) now_.barrier_cost = barrier_cost(now_.x, now_.cost);
}

// Moves relaxed bounds back to the relaxation that the current mu permits. Returns true if the
// iterate had to move with them.
bool BarrierRun::tighten_bounds() {
  bool has_moved = false;
  for (int i = 0; i < n_; ++i) {
    double& x = now_.x[i];
    const double l = program_.lower()[i], u = program_.upper()[i];
    if (const double room = bound_room_of(i, l); lower_[i] > -infinity && lower_[i] < l - room) {
      const double least = kept_room * std::min(room, x - lower_[i]);
      lower_[i] = l - room;
      has_moved = has_moved || x < lower_[i] + least;
      x = std::max(x, lower_[i] + least);
    }
    if (const double room = bound_room_of(i, u); upper_[i] < infinity && upper_[i] > u + room) {
      const double least = kept_room * std::min(room, upper_[i] - x);
      upper_[i] = u + room;
      has_moved = has_moved || x > upper_[i] - least;
      x = std::min(x, upper_[i] - least);
    }
  }
  return has_moved;
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

// Multipliers of the rows that minimise the residual of stationarity |grad f + J'lambda + z|; zero
// if they exceed `most`.
VectorXd BarrierRun::estimate_multipliers(double most) {
  qp::SparseQp& qp = engine_.qp;
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

// Nearly dependent rows let multipliers grow against each other, and the Hessian with them. Much
// smaller multipliers with the same effect replace them.
void BarrierRun::shrink_multipliers() {
  const VectorXd estimate = estimate_multipliers(much_smaller * largest(lambda_));
  if (largest(estimate) > 0.0) lambda_ = estimate;
}

}  // namespace saltus
