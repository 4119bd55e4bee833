#include "saltus/integrators/interval_field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

void check_sizes(const Function& function, const char* what, int inputs) {
  if (function.inputs() != inputs)
    throw DefinitionError(
        fmt::format("the {} of an interval must take (t, x, u, p) of {} entries, but takes {}.",
                    what, inputs, function.inputs()));
}

// y += a x over n entries.
void add_multiple(int n, double a, const double* x, double* y) {
  for (int i = 0; i < n; ++i) y[i] += a * x[i];
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

  // Directions in the order of w, and what each row of z takes from them.
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

  // One list of Jacobian entries for f and L, without those that no direction reaches.
  const auto reached = [&](int col) { return is_state(col) || !coefficients_[col].empty(); };
  dynamics_entries_ = dynamics_.jacobian_pattern().entries();
  dynamics_.jacobian_pattern().for_each([&](int r, int c, int e) {
    if (reached(c)) jacobian_entries_.push_back({r, c, e});
  });
  int hessian_entries = dynamics_.hessian_pattern().entries();
  const auto note_curvature = [&](const Function& function, bool cost) {
    function.hessian_pattern().for_each([&](int r, int c, int e) {
      if (!reached(r) || !reached(c)) return;
      curvature_entries_.push_back({r, c, e, cost});
      curvature_rows_.push_back(r);
      curvature_rows_.push_back(c);
    });
  };
  note_curvature(dynamics_, false);
  if (running_cost_) {
    cost_entries_ = running_cost_.jacobian_pattern().entries();
    running_cost_.jacobian_pattern().for_each([&](int r, int c, int e) {
      if (reached(c)) jacobian_entries_.push_back({nx_ + r, c, dynamics_entries_ + e});
    });
    note_curvature(running_cost_, true);
    hessian_entries = std::max(hessian_entries, running_cost_.hessian_pattern().entries());
  }
  direct_entries_.resize(directions());
  for (const Entry& e : jacobian_entries_) {
    if (is_state(e.col)) state_entries_.push_back(e);
    for (const Coefficient& coefficient : coefficients_[e.col])
      direct_entries_[coefficient.direction].push_back({e.row, e.entry, coefficient});
  }
  std::sort(curvature_rows_.begin(), curvature_rows_.end());
  curvature_rows_.erase(std::unique(curvature_rows_.begin(), curvature_rows_.end()),
                        curvature_rows_.end());

  hessian_scratch_.resize(hessian_entries);
  product_.setZero(sizes_.size(), directions());
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
  std::fill_n(gradient, sizes_.size(), 0.0);
  for (const Entry& e : jacobian_entries_) gradient[e.col] += entries[e.entry] * weights[e.row];
}

void IntervalField::scaled_state_jacobian(const double* entries, double* dense) const {
  const int n = outputs();
  std::fill_n(dense, n * n, 0.0);
  for (const Entry& e : jacobian_entries_)
    if (is_state(e.col)) dense[(e.col - 1) * n + e.row] = h_ * entries[e.entry];
}

void IntervalField::rate_sensitivity(double s, const double* phi, const double* entries,
                                     const RowMajorMatrix& sensitivity,
                                     RowMajorMatrix& rates) const {
  const int n = directions();
  rates.setZero();
  for (const Entry& e : jacobian_entries_) {
    const double slope = h_ * entries[e.entry];
    double* row = rates.data() + e.row * n;
    if (is_state(e.col))
      add_multiple(n, slope, sensitivity.data() + (e.col - 1) * n, row);
    else
      for (const Coefficient& coefficient : coefficients_[e.col])
        row[coefficient.direction] += slope * coefficient.at(s);
  }
  if (differentiates_time())
    for (int r = 0; r < outputs(); ++r) rates(r, h_direction_) += phi[r];
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
  const int n = directions();
  const double* rows = sensitivity.data();
  for (const int r : curvature_rows_) std::fill_n(product_.data() + r * n, n, 0.0);

  // product = M Z for M = (weights' phi)_zz, entry by entry of its lower triangle.
  const auto multiply = [&](int r, int c, double m) {
    double* out = product_.data() + r * n;
    if (is_state(c))
      add_multiple(n, m, rows + (c - 1) * n, out);
    else
      for (const Coefficient& coefficient : coefficients_[c])
        out[coefficient.direction] += m * coefficient.at(s);
  };
  const auto accumulate = [&](bool cost) {
    for (const CurvatureEntry& e : curvature_entries_) {
      if (e.cost != cost) continue;
      const double m = h_ * hessian_scratch_[e.entry];
      multiply(e.row, e.col, m);
      if (e.row != e.col) multiply(e.col, e.row, m);
    }
  };
  if (curvature == Curvature::exact && dynamics_.hessian_pattern().entries() > 0) {
    dynamics_.hessian(z, weights, hessian_scratch_.data(), Curvature::exact);
    accumulate(false);
  }
  if (running_cost_ && running_cost_.hessian_pattern().entries() > 0) {
    running_cost_.hessian(z, weights + nx_, hessian_scratch_.data(), curvature);
    accumulate(true);
  }

  // sum += Z' product, lower triangle.
  for (const int r : curvature_rows_) {
    const double* right = product_.data() + r * n;
    if (is_state(r)) {
      const double* left = rows + (r - 1) * n;
      for (int i = 0; i < n; ++i)
        if (left[i] != 0.0) add_multiple(i + 1, left[i], right, sum.data() + i * n);
    } else {
      for (const Coefficient& coefficient : coefficients_[r])
        add_multiple(coefficient.direction + 1, coefficient.at(s), right,
                     sum.data() + coefficient.direction * n);
    }
  }
}

void IntervalField::pull_back(double s, const double* gradient, const RowMajorMatrix& sensitivity,
                              double* along) const {
  const int n = directions();
  std::fill_n(along, n, 0.0);
  for (int col = 0; col < sizes_.size(); ++col) {
    if (is_state(col))
      add_multiple(n, gradient[col], sensitivity.data() + (col - 1) * n, along);
    else
      for (const Coefficient& coefficient : coefficients_[col])
        along[coefficient.direction] += gradient[col] * coefficient.at(s);
  }
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
