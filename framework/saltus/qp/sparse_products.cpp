// Products of a sparse program with H and J, for residuals and refinement.
//
//     stationarity = H v [+ g] + E'y - G'lambda,   equality rows = E v [- e],   sides = G v
//
// E and G contain the rows of J, and the sides of rows and bounds with their signs.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "saltus/qp/sparse_system.hpp"

namespace saltus::qp {

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

  std::fill_n(stationarity, variables(), 0.0);
  add_transposed(lambda, stationarity);
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
  if (best_is_of_factor_ && std::equal(v, v + n_, best_.data())) {
    // The last solution contains p = w J dv. For large w, J dv is small: a direct evaluation would
    // lose it to cancellation, p does not.
    for (int i = 0; i < m_; ++i) row_work_[i] = -best_[n_ + i] * diagonal_[n_ + i];
  } else {
    multiply_rows(v);
  }
  spread(v, side);
}

void SparseSystem::add_transposed(const double* side, double* v) {
  row_work_.setZero();
  for (std::size_t i = 0; i < sides_.size(); ++i)
    row_work_[sides_[i].row] += sides_[i].sign * side[i];
  for (int i = 0; i < n_; ++i) v[i] += row_work_[m_ + i];
  row_pattern_.for_each([&](int i, int j, int e) { v[j] += rows_[e] * row_work_[i]; });
}

void SparseSystem::row_sizes(double* side) {
  row_work_.setZero();
  row_pattern_.for_each([&](int i, int, int e) { row_work_[i] += rows_[e] * rows_[e]; });
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const int row = sides_[i].row;
    side[i] = row < m_ ? std::sqrt(row_work_[row]) : 1.0;
  }
}

}  // namespace saltus::qp
