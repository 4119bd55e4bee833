#include "saltus/qp/sparse_system.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "saltus/qp/side_residual.hpp"

namespace saltus::qp {
namespace {

// rho and delta, in units of the data, in the order in which they are tried. A pivot of this size
// that is eliminated early costs digits, 1e-16 over its size of them; refinement wins them back as
// long as it converges, which it does not where rho or delta outweigh what they are added to (1/w
// of a row that holds hard). So neither the largest nor the smallest is always right.
constexpr std::array regularisations{1e-12, 1e-14, 1e-10, 1e-8, 1e-6};
// Backward error with which a solution passes.
constexpr double accurate = 1e-13;
// A row with less weight than this does not hold anything back.
constexpr double least_weight = 1e-20;
constexpr int refinements = 10;
// A refinement that does not remove half of the residual has met rounding.
constexpr double worthwhile = 0.5;
// Of a residual relative to its largest term: there is nothing left to remove.
constexpr double rounding = 1e-16;

// Lower triangle of [H, J'; J, D] with a full diagonal.
SparsityPattern matrix_pattern(const SparsityPattern& hessian, const SparsityPattern& rows) {
  const int n = hessian.rows(), m = rows.rows();
  std::vector<std::pair<int, int>> pairs;
  hessian.for_each([&](int i, int j, int) { pairs.emplace_back(i, j); });
  rows.for_each([&](int i, int j, int) { pairs.emplace_back(n + i, j); });
  for (int i = 0; i < n + m; ++i) pairs.emplace_back(i, i);
  return SparsityPattern::from_pairs(n + m, n + m, std::move(pairs));
}

std::vector<signed char> expected_signs(int n, int m) {
  std::vector<signed char> signs(n + m, 1);
  std::fill(signs.begin() + n, signs.end(), static_cast<signed char>(-1));
  return signs;
}

double norm(const Eigen::Ref<const VectorXd>& v) {
  double worst = 0.0;
  for (const double x : v) raise(worst, x);
  return worst;
}

}  // namespace

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
      ldl_(matrix_pattern(hessian, rows), expected_signs(n_, m_)),
      hessian_diagonal_(VectorXd::Zero(n_)),
      diagonal_(VectorXd::Zero(n_ + m_)),
      right_side_(VectorXd::Zero(n_ + m_)),
      solution_(VectorXd::Zero(n_ + m_)),
      residual_(VectorXd::Zero(n_ + m_)),
      best_(VectorXd::Zero(n_ + m_)),
      row_work_(VectorXd::Zero(m_ + n_)) {
  equality_rows_.reserve(m_);
  sides_.reserve(2 * (n_ + m_));
  const SparsityPattern pattern = matrix_pattern(hessian, rows);
  hessian.for_each([&](int i, int j, int) { hessian_slot_.push_back(pattern.find(i, j)); });
  rows.for_each([&](int i, int j, int) { row_slot_.push_back(pattern.find(n_ + i, j)); });
  for (int i = 0; i < n_ + m_; ++i) diagonal_slot_.push_back(pattern.find(i, i));
}

bool SparseSystem::load(const SparseQp& qp) {
  if (qp.variables() != n_ || qp.hessian.size() != hessian_.size() ||
      qp.rows.size() != rows_.size() || qp.row_lower.size() != m_)
    return false;
  if (!qp.hessian.allFinite() || !qp.rows.allFinite() || !qp.gradient.allFinite()) return false;
  // False for NaN as well. An infinite value cannot be attained.
  const auto is_interval = [](double lower, double upper) {
    return lower <= upper && lower < infinity && upper > -infinity;
  };
  for (int i = 0; i < n_; ++i)
    if (!is_interval(qp.lower[i], qp.upper[i])) return false;
  for (int i = 0; i < m_; ++i)
    if (!is_interval(qp.row_lower[i], qp.row_upper[i])) return false;

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
  cost_unit_ = std::max(1.0, norm(gradient_));
  hessian_ /= cost_unit_;
  gradient_ /= cost_unit_;
  for (int i = 0; i < n_; ++i) hessian_diagonal_[i] /= is_fixed_[i] ? 1.0 : cost_unit_;
  scale_ = std::max(1.0, norm(hessian_));
  row_scale_ = norm(rows_);

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
  // What holds a fixed variable is whatever its stationarity lacks.
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

void SparseSystem::add_hessian_times(const double* v, double* out) const {
  hessian_pattern_.for_each([&](int i, int j, int e) {
    out[i] += hessian_[e] * v[j];
    if (i != j) out[j] += hessian_[e] * v[i];
  });
}

void SparseSystem::evaluate(const double* v, const double* y, const double* lambda,
                            double* stationarity, double* equality, double* side) {
  apply(v, y, lambda, stationarity, equality, side);
  for (int i = 0; i < n_; ++i) stationarity[i] += gradient_[i];
  for (std::size_t i = 0; i < equality_rows_.size(); ++i) equality[i] -= equality_[i];
}

void SparseSystem::apply(const double* v, const double* y, const double* lambda,
                         double* stationarity, double* equality, double* side) {
  multiply_rows(v);
  spread(v, side);
  for (std::size_t i = 0; i < equality_rows_.size(); ++i)
    equality[i] = row_work_[equality_rows_[i]];
  for (int i = static_cast<int>(equality_rows_.size()); i < equalities(); ++i) equality[i] = 0.0;

  multiply_transposed(lambda, stationarity);
  for (int i = 0; i < n_; ++i) stationarity[i] = -stationarity[i];
  for (std::size_t i = 0; i < equality_rows_.size(); ++i) {
    const int row = equality_rows_[i];
    for (int e = row_pattern_.row_begin(row); e < row_pattern_.row_end(row); ++e)
      stationarity[row_pattern_.col(e)] += rows_[e] * y[i];
  }
  add_hessian_times(v, stationarity);
}

double SparseSystem::cost(const double* v) {
  double total = 0.0;
  for (int i = 0; i < n_; ++i) total += gradient_[i] * v[i];
  hessian_pattern_.for_each(
      [&](int i, int j, int e) { total += (i == j ? 0.5 : 1.0) * hessian_[e] * v[i] * v[j]; });
  return total;
}

void SparseSystem::multiply_rows(const double* v) {
  row_work_.setZero();
  row_pattern_.for_each([&](int i, int j, int e) { row_work_[i] += rows_[e] * v[j]; });
}

void SparseSystem::spread(const double* v, double* side) const {
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const auto [row, sign] = sides_[i];
    side[i] = sign * (row < m_ ? row_work_[row] : v[row - m_]);
  }
  for (int i = static_cast<int>(sides_.size()); i < sides(); ++i) side[i] = 0.0;
}

void SparseSystem::multiply(const double* v, double* side) {
  if (std::equal(v, v + n_, best_.data())) {
    // The last solution came with p = w J dv. J dv is small where w is large, and lost to
    // cancellation if it is added up; p is not.
    for (int i = 0; i < m_; ++i) row_work_[i] = -best_[n_ + i] * diagonal_[n_ + i];
  } else {
    multiply_rows(v);
  }
  spread(v, side);
}

void SparseSystem::multiply_transposed(const double* side, double* v) {
  row_work_.setZero();
  for (std::size_t i = 0; i < sides_.size(); ++i)
    row_work_[sides_[i].row] += sides_[i].sign * side[i];
  for (int i = 0; i < n_; ++i) v[i] = row_work_[m_ + i];
  for (int i = n_; i < variables(); ++i) v[i] = 0.0;
  row_pattern_.for_each([&](int i, int j, int e) { v[j] += rows_[e] * row_work_[i]; });
}

bool SparseSystem::factor(const double* weights) {
  diagonal_.setZero();
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const int row = sides_[i].row;
    diagonal_[row < m_ ? n_ + row : row - m_] += weights[i];
  }
  for (int i = n_; i < n_ + m_; ++i) diagonal_[i] = -1.0 / std::max(diagonal_[i], least_weight);
  for (const int row : equality_rows_) diagonal_[n_ + row] = 0.0;
  diagonal_.head(n_).array() += shift_;

  if (!expects_convex_) return factor_with(regularisations[level_]);
  for (std::size_t tried = 0; tried < regularisations.size(); ++tried) {
    if (factor_with(regularisations[level_])) return true;
    next_level();
  }
  return false;
}

void SparseSystem::next_level() {
  level_ = (level_ + 1) % regularisations.size();
  ++changes_;
}

bool SparseSystem::factor_with(double regularisation) {
  const double rho = regularisation * scale_, delta = regularisation;
  for (int i = 0; i < n_; ++i)
    ldl_.set(diagonal_slot_[i], hessian_diagonal_[i] + diagonal_[i] + rho);
  for (int i = n_; i < n_ + m_; ++i) ldl_.set(diagonal_slot_[i], diagonal_[i] - delta);
  return expects_convex_ ? ldl_.factor() : ldl_.factor_with_inertia();
}

void SparseSystem::multiply_matrix(const double* x, double* out) const {
  for (int i = 0; i < n_ + m_; ++i) out[i] = diagonal_[i] * x[i];
  for (int i = 0; i < n_; ++i)
    if (is_fixed_[i]) out[i] += x[i];
  add_hessian_times(x, out);
  row_pattern_.for_each([&](int i, int j, int e) {
    out[n_ + i] += rows_[e] * x[j];
    out[j] += rows_[e] * x[n_ + i];
  });
}

// Variables and rows have units of their own, and large weights make the first part's terms large:
// each residual counts relative to what was added up in its part.
double SparseSystem::backward_error() const {
  const auto v = solution_.head(n_), p = solution_.tail(m_);
  double terms_of_variables = 0.0, terms_of_rows = 0.0;
  for (int i = 0; i < n_; ++i) {
    raise(terms_of_variables, diagonal_[i] * v[i]);
    raise(terms_of_variables, right_side_[i]);
  }
  for (int i = n_; i < n_ + m_; ++i) {
    raise(terms_of_rows, diagonal_[i] * solution_[i]);
    raise(terms_of_rows, right_side_[i]);
  }
  const double largest_v = norm(v);
  raise(terms_of_variables, scale_ * largest_v);
  raise(terms_of_variables, row_scale_ * norm(p));
  raise(terms_of_rows, row_scale_ * largest_v);
  const double of_variables = norm(residual_.head(n_)), of_rows = norm(residual_.tail(m_));
  return std::max(of_variables > 0.0 ? of_variables / terms_of_variables : 0.0,
                  of_rows > 0.0 ? of_rows / terms_of_rows : 0.0);
}

// Solves, refines, and keeps the solution if its error is smaller than the smallest so far.
void SparseSystem::refine(double& smallest) {
  solution_ = right_side_;
  ldl_.solve(solution_.data());
  double last = infinity;
  for (int step = 0;; ++step) {
    multiply_matrix(solution_.data(), residual_.data());
    residual_ = right_side_ - residual_;
    const double error = backward_error();
    if (error < smallest) {
      smallest = error;
      best_ = solution_;
    }
    if (!(error < worthwhile * last) || error < rounding || step == refinements) return;
    last = error;
    ldl_.solve(residual_.data());
    solution_ += residual_;
  }
}

void SparseSystem::solve(const double* rv, const double* ry, double* dv, double* dy) {
  right_side_.setZero();
  for (int i = 0; i < n_; ++i) right_side_[i] = -rv[i];
  for (std::size_t i = 0; i < equality_rows_.size(); ++i)
    right_side_[n_ + equality_rows_[i]] = -ry[i];

  // Others are tried where this one's solution is poor; the next factor begins with the last one
  // tried.
  double smallest = infinity;
  refine(smallest);
  for (std::size_t tried = 1; tried < regularisations.size() && smallest > accurate; ++tried) {
    next_level();
    if (factor_with(regularisations[level_])) refine(smallest);
  }
  for (int i = 0; i < n_; ++i) dv[i] = best_[i];
  for (int i = n_; i < variables(); ++i) dv[i] = 0.0;
  for (std::size_t i = 0; i < equality_rows_.size(); ++i) dy[i] = best_[n_ + equality_rows_[i]];
  for (int i = static_cast<int>(equality_rows_.size()); i < equalities(); ++i) dy[i] = 0.0;
}

}  // namespace saltus::qp
