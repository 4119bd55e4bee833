#include "saltus/integrators/interval_field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/integrators/rows.hpp"

namespace saltus {

using rows::add_multiple;
using rows::Lanes;
using rows::lanes;

namespace {

void check_sizes(const Function& function, const char* what, int inputs) {
  if (function.inputs() != inputs)
    throw DefinitionError(
        fmt::format("the {} of an interval must take (t, x, u, p) of {} entries, but takes {}.",
                    what, inputs, function.inputs()));
}

// result[i] = scale * sum over k < count of weight(k) * row(k)[i], for i < n.
template <class Row, class Weight>
void sum_rows(int n, int count, const Row& row, const Weight& weight, double scale,
              double* result) {
  int i = 0;
  for (; i + lanes <= n; i += lanes) {
    Lanes sum{};
    for (int k = 0; k < count; ++k) sum += weight(k) * rows::load(row(k) + i);
    rows::store(scale * sum, result + i);
  }
  for (; i < n; ++i) {
    double sum = 0.0;
    for (int k = 0; k < count; ++k) sum += weight(k) * row(k)[i];
    result[i] = scale * sum;
  }
}

}  // namespace

IntervalField::IntervalField(const IntervalProblem& problem)
    : dynamics_(problem.dynamics),
      running_cost_(problem.running_cost),
      shape_(problem.shape),
      sizes_(problem.arguments),
      interval_{problem.arguments.nx, problem.coefficients(), problem.arguments.np},
      nx_(problem.arguments.nx),
      nu_(problem.arguments.nu),
      nq_(problem.nq()),
      c_(problem.coefficients()),
      p_(problem.arguments.np) {
  if (!dynamics_) throw DefinitionError("an interval needs dynamics, but none are given.");
  check_sizes(dynamics_, "dynamics", sizes_.size());
  if (dynamics_.outputs() != nx_)
    throw DefinitionError(fmt::format("the dynamics of an interval with {} states return {} rates.",
                                      nx_, dynamics_.outputs()));
  if (running_cost_) check_sizes(running_cost_, "running costs", sizes_.size());
  const auto& wanted = problem.differentiate_parameter;
  if (!wanted.empty() && static_cast<int>(wanted.size()) != sizes_.np)
    throw DefinitionError(fmt::format("differentiate_parameter has {} entries for {} parameters.",
                                      wanted.size(), sizes_.np));

  // Directions in the order of w, and the coefficients of each row of z.
  coefficients_.resize(sizes_.size());
  for (int i = 0; i < nx_; ++i) column_.push_back(interval_.x(i));
  for (int i = 0; i < interval_.nc; ++i) column_.push_back(interval_.c(i));
  for (int i = 0; i < nu_; ++i) {
    auto& row = coefficients_[sizes_.u(i)];
    if (shape_ == InputShape::constant) {
      row.push_back({nx_ + i, 1.0, 0.0});
    } else {
      row.push_back({nx_ + i, 1.0, -1.0});
      row.push_back({nx_ + nu_ + i, 0.0, 1.0});
    }
  }
  for (int i = 0; i < sizes_.np; ++i) {
    if (wanted.empty() || !wanted[i]) continue;
    coefficients_[sizes_.p(i)].push_back({directions(), 1.0, 0.0});
    column_.push_back(interval_.p(i));
  }
  if (problem.differentiate_time) {
    coefficients_[sizes_.t()].push_back({directions(), 1.0, 0.0});
    column_.push_back(interval_.t0());
    h_direction_ = directions();
    coefficients_[sizes_.t()].push_back({h_direction_, 0.0, 1.0});
    column_.push_back(interval_.h());
  }

  // One list of Jacobian entries of f and L, without entries that no direction affects.
  const auto reached = [&](int col) { return is_state(col) || !coefficients_[col].empty(); };
  dynamics_entries_ = dynamics_.jacobian_pattern().entries();
  dynamics_.jacobian_pattern().for_each([&](int r, int c, int e) {
    if (reached(c)) jacobian_entries_.push_back({r, c, e});
  });
  place_directions();
  int hessian_entries = 0;
  std::vector<std::vector<Factor>> curvature(sizes_.size());
  const auto note_curvature = [&](const Function& function) {
    function.hessian_pattern().for_each([&](int r, int c, int e) {
      if (!reached(r) || !reached(c)) return;
      curvature[r].push_back(factor(hessian_entries + e, c));
      if (r != c) curvature[c].push_back(factor(hessian_entries + e, r));
    });
    hessian_entries += function.hessian_pattern().entries();
  };
  note_curvature(dynamics_);
  dynamics_curvature_ = hessian_entries;
  if (running_cost_) {
    cost_entries_ = running_cost_.jacobian_pattern().entries();
    running_cost_.jacobian_pattern().for_each([&](int r, int c, int e) {
      if (reached(c)) jacobian_entries_.push_back({nx_ + r, c, dynamics_entries_ + e});
    });
    note_curvature(running_cost_);
  }
  direct_entries_.resize(directions());
  rate_factors_.resize(outputs());
  gradient_factors_.resize(sizes_.size());
  for (const Entry& e : jacobian_entries_) {
    rate_factors_[e.row].push_back(factor(e.entry, e.col));
    gradient_factors_[e.col].push_back({e.entry, false, e.row});
    if (is_state(e.col)) state_entries_.push_back(e);
    for (const Coefficient& coefficient : coefficients_[e.col])
      direct_entries_[coefficient.direction].push_back({e.row, e.entry, coefficient});
  }
  for (int col = 0; col < sizes_.size(); ++col)
    if (!curvature[col].empty()) curvature_rows_.push_back({col, curvature[col]});

  hessian_scratch_.resize(hessian_entries);
  product_.setZero(static_cast<int>(curvature_rows_.size()), padded_directions());
}

int IntervalField::padded_directions() const { return rows::padded(directions()); }

// One row for each varying entry of z that is not a state, and a last row for h.
void IntervalField::place_directions() {
  int count = 0;
  for (int col = 0; col < sizes_.size(); ++col)
    direct_row_.push_back(is_state(col) ? col - 1 : coefficients_[col].empty() ? -1 : count++);
  direct_rows_.setZero(count + 1, padded_directions());
  if (differentiates_time()) direct_rows_(count, h_direction_) = 1.0;
  for (int col = 0; col < sizes_.size(); ++col)
    for (const Coefficient& c : coefficients_[col]) {
      direct_rows_(direct_row_[col], c.direction) = c.constant;
      if (c.slope != 0.0) moving_.push_back({direct_row_[col], c});
    }
}

void IntervalField::move_directions(double s) const {
  for (const MovingEntry& m : moving_)
    direct_rows_(m.row, m.coefficient.direction) = m.coefficient.at(s);
}

void IntervalField::load(const double* w) {
  std::copy_n(w + interval_.c(), interval_.nc, c_.begin());
  std::copy_n(w + interval_.p(), interval_.np, p_.begin());
  t0_ = w[interval_.t0()];
  h_ = w[interval_.h()];
}

void IntervalField::argument(double s, const double* x, double* z) const {
  z[sizes_.t()] = t0_ + s * h_;
  std::copy_n(x, nx_, z + sizes_.x());
  if (shape_ == InputShape::constant)
    std::copy_n(c_.begin(), nu_, z + sizes_.u());
  else
    for (int i = 0; i < nu_; ++i) z[sizes_.u(i)] = (1.0 - s) * c_[i] + s * c_[nu_ + i];
  std::copy(p_.begin(), p_.end(), z + sizes_.p());
}

void IntervalField::value(const double* z, double* phi) const {
  dynamics_.value(z, phi);
  if (running_cost_) running_cost_.value(z, phi + nx_);
}

void IntervalField::jacobian(const double* z, double* phi, double* entries) const {
  dynamics_.jacobian(z, phi, entries);
  if (running_cost_) running_cost_.jacobian(z, phi + nx_, entries + dynamics_entries_);
}

void IntervalField::adjoint(const double* entries, const double* weights, double* gradient) const {
  for (int col = 0; col < sizes_.size(); ++col) {
    double sum = 0.0;
    for (const Factor& f : gradient_factors_[col]) sum += entries[f.entry] * weights[f.row];
    gradient[col] = sum;
  }
}

void IntervalField::scaled_state_jacobian(const double* entries, double* dense) const {
  const int n = outputs();
  std::fill_n(dense, n * n, 0.0);
  for (const Entry& e : jacobian_entries_)
    if (is_state(e.col)) dense[(e.col - 1) * n + e.row] = h_ * entries[e.entry];
}

void IntervalField::rate_sensitivity(double s, const double* phi, const double* entries,
                                     const RowMajorMatrix& sensitivity, double* rates) const {
  const int n = static_cast<int>(sensitivity.cols());
  move_directions(s);
  const double* along_h = direct_rows_.data() + (direct_rows_.rows() - 1) * direct_rows_.cols();
  for (int r = 0; r < outputs(); ++r) {
    const std::vector<Factor>& factors = rate_factors_[r];
    double* rate = rates + r * n;
    sum_rows(
        n, static_cast<int>(factors.size()), [&](int k) { return row_of(factors[k], sensitivity); },
        [&](int k) { return entries[factors[k].entry]; }, h_, rate);
    if (differentiates_time()) add_multiple(n, phi[r], along_h, rate);
  }
}

void IntervalField::rate_sensitivity(double s, const double* phi, const double* entries,
                                     int direction, const double* sensitivity, double* rate) const {
  std::fill_n(rate, outputs(), 0.0);
  for (const Entry& e : state_entries_) rate[e.row] += entries[e.entry] * sensitivity[e.col - 1];
  for (const DirectEntry& e : direct_entries_[direction])
    rate[e.row] += entries[e.entry] * e.coefficient.at(s);
  for (int r = 0; r < outputs(); ++r) rate[r] *= h_;
  if (direction == h_direction_) add_multiple(outputs(), 1.0, phi, rate);
}

void IntervalField::add_curvature(double s, const double* z, const double* weights,
                                  const RowMajorMatrix& sensitivity, Curvature curvature,
                                  RowMajorMatrix& sum) const {
  if (curvature_rows_.empty()) return;
  double* second = hessian_scratch_.data();
  if (curvature == Curvature::exact)
    dynamics_.hessian(z, weights, second, Curvature::exact);
  else
    std::fill_n(second, dynamics_curvature_, 0.0);
  if (running_cost_)
    running_cost_.hessian(z, weights + nx_, second + dynamics_curvature_, curvature);

  // product = h M Z for M = (weights' phi)_zz.
  const int n = static_cast<int>(sensitivity.cols());
  move_directions(s);
  const int stride = static_cast<int>(product_.cols());
  for (std::size_t q = 0; q < curvature_rows_.size(); ++q) {
    const std::vector<Factor>& factors = curvature_rows_[q].factors;
    sum_rows(
        n, static_cast<int>(factors.size()), [&](int k) { return row_of(factors[k], sensitivity); },
        [&](int k) { return second[factors[k].entry]; }, h_, product_.data() + q * stride);
  }
  // sum += Z' product, at least the lower triangle.
  for (std::size_t q = 0; q < curvature_rows_.size(); ++q) {
    const int col = curvature_rows_[q].col;
    const double* right = product_.data() + q * stride;
    const auto add_to = [&](int i, double left) {
      const int count = std::min(n, rows::padded(i + 1));
      add_multiple(count, left, right, sum.data() + i * sum.cols());
    };
    if (is_state(col)) {
      const double* left = sensitivity.data() + (col - 1) * n;
      for (int i = 0; i < directions(); ++i) add_to(i, left[i]);
    } else {
      for (const Coefficient& coefficient : coefficients_[col])
        add_to(coefficient.direction, coefficient.at(s));
    }
  }
}

void IntervalField::pull_back(double s, const double* gradient, const RowMajorMatrix& sensitivity,
                              double* along) const {
  const int n = static_cast<int>(sensitivity.cols());
  sum_rows(
      n, nx_, [&](int k) { return sensitivity.data() + k * n; },
      [&](int k) { return gradient[sizes_.x(k)]; }, 1.0, along);
  for (int col = 0; col < sizes_.size(); ++col)
    for (const Coefficient& coefficient : coefficients_[col])
      along[coefficient.direction] += gradient[col] * coefficient.at(s);
}

void IntervalField::differentiate_argument(double s, const RowMajorMatrix& sensitivity,
                                           const double* moves, RowMajorMatrix& dz) const {
  const int n = directions();
  for (int col = 0; col < sizes_.size(); ++col) {
    double* row = dz.data() + col * n;
    if (is_state(col)) {
      std::copy_n(sensitivity.data() + (col - 1) * sensitivity.cols(), n, row);
      continue;
    }
    std::fill_n(row, n, 0.0);
    const int input = col - sizes_.u();
    double slope = col == sizes_.t() ? h_ : 0.0;
    if (shape_ == InputShape::linear && input >= 0 && input < nu_)
      slope = c_[nu_ + input] - c_[input];
    if (slope != 0.0) add_multiple(n, slope, moves, row);
    for (const Coefficient& coefficient : coefficients_[col])
      row[coefficient.direction] += coefficient.at(s);
  }
}

void IntervalField::rate_differential(const double* phi, const double* entries,
                                      const RowMajorMatrix& dz, RowMajorMatrix& rates) const {
  const int n = directions();
  rates.setZero();
  const auto add = [&](int r, int c, double entry) {
    add_multiple(n, h_ * entry, dz.data() + c * n, rates.data() + r * n);
  };
  dynamics_.jacobian_pattern().for_each([&](int r, int c, int e) { add(r, c, entries[e]); });
  if (running_cost_)
    running_cost_.jacobian_pattern().for_each(
        [&](int r, int c, int e) { add(nx_ + r, c, entries[dynamics_entries_ + e]); });
  if (!differentiates_time()) return;
  for (int r = 0; r < outputs(); ++r) rates(r, h_direction_) += phi[r];
}

void IntervalField::add_moving_curvature(const double* z, const double* weights,
                                         const RowMajorMatrix& dz, Curvature curvature,
                                         RowMajorMatrix& sum) const {
  const auto add = [&](const Function& function, const double* weight, Curvature kind) {
    function.hessian(z, weight, hessian_scratch_.data(), kind);
    function.hessian_pattern().for_each([&](int a, int b, int e) {
      const double second = h_ * hessian_scratch_[e];
      if (second == 0.0) return;
      sum.noalias() += second * dz.row(a).transpose() * dz.row(b);
      if (a != b) sum.noalias() += second * dz.row(b).transpose() * dz.row(a);
    });
  };
  if (curvature == Curvature::exact) add(dynamics_, weights, curvature);
  if (running_cost_) add(running_cost_, weights + nx_, curvature);
}

void IntervalField::slope_differential(const double* gradient, double* along) const {
  std::fill_n(along, directions(), 0.0);
  for (int col = 0; col < sizes_.size(); ++col)
    for (const Coefficient& coefficient : coefficients_[col])
      along[coefficient.direction] += gradient[col] * coefficient.slope;
}

void IntervalField::explicit_rate(const double* entries, double* rate) const {
  explicit_slope(dynamics_.jacobian_pattern(), entries, rate);
  if (running_cost_)
    explicit_slope(running_cost_.jacobian_pattern(), entries + dynamics_entries_, rate + nx_);
  for (int r = 0; r < outputs(); ++r) rate[r] *= h_;
}

void IntervalField::differential(const SparsityPattern& pattern, const double* entries, double s,
                                 const RowMajorMatrix& sensitivity, RowMajorMatrix& result) const {
  const int n = directions();
  for (int r = 0; r < pattern.rows(); ++r) {
    double* row = result.data() + r * n;
    std::fill_n(row, n, 0.0);
    for (int e = pattern.row_begin(r); e < pattern.row_end(r); ++e) {
      const int col = pattern.col(e);
      if (is_state(col))
        add_multiple(n, entries[e], sensitivity.data() + (col - 1) * n, row);
      else
        for (const Coefficient& coefficient : coefficients_[col])
          row[coefficient.direction] += entries[e] * coefficient.at(s);
    }
  }
}

void IntervalField::explicit_slope(const SparsityPattern& pattern, const double* entries,
                                   double* slope) const {
  std::fill_n(slope, pattern.rows(), 0.0);
  pattern.for_each([&](int r, int col, int e) {
    const int input = col - sizes_.u();
    if (col == sizes_.t())
      slope[r] += entries[e] * h_;
    else if (shape_ == InputShape::linear && input >= 0 && input < nu_)
      slope[r] += entries[e] * (c_[nu_ + input] - c_[input]);
  });
}

void IntervalField::scatter(const RowMajorMatrix& sensitivity, MatrixXd& derivative) const {
  derivative.setZero();
  for (int d = 0; d < directions(); ++d)
    for (int r = 0; r < outputs(); ++r) derivative(r, column_[d]) = sensitivity(r, d);
}

void IntervalField::scatter_symmetric(const RowMajorMatrix& lower, MatrixXd& hessian) const {
  hessian.setZero();
  for (int i = 0; i < directions(); ++i)
    for (int j = 0; j <= i; ++j) {
      hessian(column_[i], column_[j]) = lower(i, j);
      hessian(column_[j], column_[i]) = lower(i, j);
    }
}

bool all_finite(const double* values, int count) {
  return std::all_of(values, values + count, [](double v) { return std::isfinite(v); });
}

}  // namespace saltus
