// SparseSystem: construction, loading of programs, and conversion of points.
#include "saltus/qp/sparse_system.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/side_residual.hpp"

namespace saltus::qp {
SparseSystem::SparseSystem(const SparsityPattern& hessian, const SparsityPattern& rows)
    : hessian_pattern_(hessian),
      row_pattern_(rows),
      n_(rows.cols()),
      m_(rows.rows()),
      hessian_(VectorXd::Zero(hessian.entries())),
      rows_(VectorXd::Zero(rows.entries())),
      gradient_(VectorXd::Zero(n_)),
      fixed_(VectorXd::Zero(n_)),
      is_fixed_(n_, 0),
      row_offset_(VectorXd::Zero(m_)),
      equality_(VectorXd::Zero(m_)),
      active_(max_sides()),
      beta_(max_sides()),
      weights_(max_sides()),
      ldl_(quasi_definite_pattern(hessian, rows), quasi_definite_signs(n_, m_)),
      hessian_diagonal_(VectorXd::Zero(n_)),
      diagonal_(VectorXd::Zero(n_ + m_)),
      right_side_(VectorXd::Zero(n_ + m_)),
      solution_(VectorXd::Zero(n_ + m_)),
      residual_(VectorXd::Zero(n_ + m_)),
      best_(VectorXd::Zero(n_ + m_)),
      row_work_(VectorXd::Zero(m_ + n_)) {
  equality_rows_.reserve(m_);
  sides_.reserve(2 * (n_ + m_));
  const SparsityPattern pattern = quasi_definite_pattern(hessian, rows);
  hessian.for_each([&](int i, int j, int) { hessian_slot_.push_back(pattern.find(i, j)); });
  rows.for_each([&](int i, int j, int) { row_slot_.push_back(pattern.find(n_ + i, j)); });
  for (int i = 0; i < n_ + m_; ++i) diagonal_slot_.push_back(pattern.find(i, i));
}

bool SparseSystem::load(const SparseQp& qp) {
  best_is_of_factor_ = false;
  if (qp.variables() != n_ || qp.hessian.size() != hessian_.size() ||
      qp.rows.size() != rows_.size() || qp.row_lower.size() != m_)
    return false;
  if (!qp.hessian.allFinite() || !qp.rows.allFinite() || !qp.gradient.allFinite()) return false;
  for (int i = 0; i < n_; ++i)
    if (Bounds{qp.lower[i], qp.upper[i]}.is_empty()) return false;
  for (int i = 0; i < m_; ++i)
    if (Bounds{qp.row_lower[i], qp.row_upper[i]}.is_empty()) return false;

  for (int i = 0; i < n_; ++i) {
    is_fixed_[i] = qp.lower[i] == qp.upper[i];
    fixed_[i] = is_fixed_[i] ? qp.lower[i] : 0.0;
  }
  hessian_ = qp.hessian;
  rows_ = qp.rows;
  gradient_ = qp.gradient;
  row_offset_.setZero();
  hessian_diagonal_.setZero();
  hessian_pattern_.for_each([&](int i, int j, int e) {
    if (is_fixed_[i] || is_fixed_[j]) {
      if (!is_fixed_[i]) gradient_[i] += hessian_[e] * fixed_[j];
      if (!is_fixed_[j]) gradient_[j] += hessian_[e] * fixed_[i];
      hessian_[e] = 0.0;
    }
    if (i == j) hessian_diagonal_[i] = is_fixed_[i] ? 1.0 : hessian_[e];
  });
  row_pattern_.for_each([&](int i, int j, int e) {
    if (!is_fixed_[j]) return;
    row_offset_[i] += rows_[e] * fixed_[j];
    rows_[e] = 0.0;
  });
  for (int i = 0; i < n_; ++i) {
    if (!is_fixed_[i]) continue;
    gradient_[i] = 0.0;
    hessian_diagonal_[i] = 1.0;
  }
  cost_unit_ = std::max(1.0, largest_entry(gradient_));
  hessian_ /= cost_unit_;
  gradient_ /= cost_unit_;
  for (int i = 0; i < n_; ++i) hessian_diagonal_[i] /= is_fixed_[i] ? 1.0 : cost_unit_;
  scale_ = std::max(1.0, largest_entry(hessian_));
  row_scale_ = largest_entry(rows_);

  sides_.clear();
  equality_rows_.clear();
  for (int i = 0; i < m_; ++i) {
    if (qp.row_lower[i] == qp.row_upper[i]) {
      equality_[equality_rows_.size()] = qp.row_lower[i] - row_offset_[i];
      equality_rows_.push_back(i);
    } else {
      add_sides(i, qp.row_lower[i], qp.row_upper[i], row_offset_[i]);
    }
  }
  for (int i = 0; i < n_; ++i)
    if (!is_fixed_[i]) add_sides(m_ + i, qp.lower[i], qp.upper[i], 0.0);
  for (int i = static_cast<int>(sides_.size()); i < sides(); ++i) active_[i] = beta_[i] = 0.0;

  for (int e = 0; e < hessian_.size(); ++e) ldl_.set(hessian_slot_[e], hessian_[e]);
  for (int e = 0; e < rows_.size(); ++e) ldl_.set(row_slot_[e], rows_[e]);
  level_ = 0;
  changes_ = 0;
  return true;
}

void SparseSystem::add_sides(int row, double lower, double upper, double offset) {
  const auto add = [&](double sign, double bound) {
    const std::size_t i = sides_.size();
    sides_.push_back({row, sign});
    active_[i] = 1.0;
    beta_[i] = sign * (bound - offset);
  };
  if (lower > -infinity) add(1.0, lower);
  if (upper < infinity) add(-1.0, upper);
}

void SparseSystem::load_point(const PrimalDualPoint& point, double* v, double* y,
                              double* lambda) const {
  for (int i = 0; i < n_; ++i) v[i] = is_fixed_[i] ? 0.0 : point.w[i];
  for (int i = n_; i < variables(); ++i) v[i] = 0.0;
  for (int i = 0; i < equalities(); ++i) y[i] = 0.0;
  if (point.lambda.size() == m_)
    for (std::size_t i = 0; i < equality_rows_.size(); ++i)
      y[i] = point.lambda[equality_rows_[i]] / cost_unit_;
  for (int i = 0; i < sides(); ++i) lambda[i] = 0.0;
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const auto [row, sign] = sides_[i];
    const VectorXd& multipliers = row < m_ ? point.lambda : point.z;
    const int index = row < m_ ? row : row - m_;
    if (index < multipliers.size())
      lambda[i] = std::max(-sign * multipliers[index] / cost_unit_, 0.0);
  }
}

void SparseSystem::unload_point(const SparseQp& qp, const double* v, const double* y,
                                const double* lambda, PrimalDualPoint& point) const {
  point.w.resize(n_);
  point.lambda.setZero(m_);
  point.z.setZero(n_);
  for (int i = 0; i < n_; ++i) point.w[i] = is_fixed_[i] ? fixed_[i] : v[i];
  for (std::size_t i = 0; i < equality_rows_.size(); ++i)
    point.lambda[equality_rows_[i]] = cost_unit_ * y[i];
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const auto [row, sign] = sides_[i];
    (row < m_ ? point.lambda[row] : point.z[row - m_]) -= sign * cost_unit_ * lambda[i];
  }
  // The multiplier of a fixed variable balances its stationarity.
  const auto add = [&](int i, double pull) {
    if (is_fixed_[i]) point.z[i] -= pull;
  };
  for (int i = 0; i < n_; ++i) add(i, qp.gradient[i]);
  qp.hessian_pattern.for_each([&](int i, int j, int e) {
    add(i, qp.hessian[e] * point.w[j]);
    if (i != j) add(j, qp.hessian[e] * point.w[i]);
  });
  qp.row_pattern.for_each([&](int i, int j, int e) { add(j, qp.rows[e] * point.lambda[i]); });
}

}  // namespace saltus::qp
