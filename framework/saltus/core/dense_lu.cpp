#include "saltus/core/dense_lu.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace saltus {
namespace {

// y -= a x over n entries.
void subtract_multiple(int n, double a, const double* x, double* y) {
  for (int i = 0; i < n; ++i) y[i] -= a * x[i];
}

}  // namespace

detail::DenseLu::DenseLu(int size)
    : size_(size),
      factors_(size * size),
      row_scale_(size),
      inverse_(size),
      pivots_(size),
      rows_(size) {}

bool detail::DenseLu::factor() {
  const double rounding = 4.0 * size_ * std::numeric_limits<double>::epsilon();
  std::iota(rows_.begin(), rows_.end(), 0);
  for (int i = 0; i < size_; ++i) {
    double largest = 0.0;
    bool finite = true;
    for (int j = 0; j < size_; ++j) {
      const double entry = std::abs(row(i)[j]);
      finite = finite && std::isfinite(entry);
      largest = std::max(largest, entry);
    }
    singular_row_ = finite ? i : -1;
    if (!finite || largest == 0.0) return false;
    row_scale_[i] = 1.0 / largest;
  }
  for (int k = 0; k < size_; ++k) {
    int best = k;
    double best_scaled_pivot = -1.0;
    for (int i = k; i < size_; ++i) {
      const double size = std::abs(row(i)[k]) * row_scale_[i];
      if (size > best_scaled_pivot) best = i, best_scaled_pivot = size;
    }
    pivots_[k] = best;
    if (!(best_scaled_pivot > rounding)) {
      // Report the remaining row with the smallest entries.
      double least = std::numeric_limits<double>::infinity();
      for (int i = k; i < size_; ++i) {
        double largest = 0.0;
        for (int j = k; j < size_; ++j) largest = std::max(largest, std::abs(row(i)[j]));
        if (largest * row_scale_[i] >= least) continue;
        least = largest * row_scale_[i];
        singular_row_ = rows_[i];
      }
      return false;
    }
    if (best != k) {
      std::swap_ranges(row(k), row(k) + size_, row(best));
      std::swap(row_scale_[k], row_scale_[best]);
      std::swap(rows_[k], rows_[best]);
    }
    const double* pivot_row = row(k);
    inverse_[k] = 1.0 / pivot_row[k];
    for (int i = k + 1; i < size_; ++i) {
      double* lower = row(i);
      if (lower[k] == 0.0) continue;
      lower[k] *= inverse_[k];
      subtract_multiple(size_ - k - 1, lower[k], pivot_row + k + 1, lower + k + 1);
    }
  }
  return true;
}

void detail::DenseLu::solve(double* b) const {
  for (int k = 0; k < size_; ++k)
    if (pivots_[k] != k) std::swap(b[k], b[pivots_[k]]);
  const double* factors = factors_.data();
  for (int i = 1; i < size_; ++i) {
    double sum = b[i];
    for (int j = 0; j < i; ++j) sum -= factors[i * size_ + j] * b[j];
    b[i] = sum;
  }
  for (int i = size_ - 1; i >= 0; --i) {
    double sum = b[i];
    for (int j = i + 1; j < size_; ++j) sum -= factors[i * size_ + j] * b[j];
    b[i] = sum * inverse_[i];
  }
}

void detail::DenseLu::solve(double* B, int columns) const {
  const double* factors = factors_.data();
  for (int k = 0; k < size_; ++k)
    if (pivots_[k] != k)
      std::swap_ranges(B + k * columns, B + (k + 1) * columns, B + pivots_[k] * columns);
  for (int i = 1; i < size_; ++i)
    for (int j = 0; j < i; ++j)
      if (const double l = factors[i * size_ + j]; l != 0.0)
        subtract_multiple(columns, l, B + j * columns, B + i * columns);
  for (int i = size_ - 1; i >= 0; --i) {
    for (int j = i + 1; j < size_; ++j)
      if (const double u = factors[i * size_ + j]; u != 0.0)
        subtract_multiple(columns, u, B + j * columns, B + i * columns);
    for (int c = 0; c < columns; ++c) B[i * columns + c] *= inverse_[i];
  }
}

void detail::DenseLu::solve_transposed(double* b) const {
  const double* factors = factors_.data();
  for (int i = 0; i < size_; ++i) {
    b[i] *= inverse_[i];
    subtract_multiple(size_ - i - 1, b[i], factors + i * size_ + i + 1, b + i + 1);
  }
  for (int i = size_ - 1; i > 0; --i) subtract_multiple(i, b[i], factors + i * size_, b);
  for (int k = size_ - 1; k >= 0; --k)
    if (pivots_[k] != k) std::swap(b[k], b[pivots_[k]]);
}

}  // namespace saltus
