// The matrix of SparseSystem::solve(): factored with a regularisation. Refinement solves the
// equations without it.
#include <algorithm>
#include <array>
#include <cstddef>

#include "saltus/qp/side_residual.hpp"
#include "saltus/qp/sparse_system.hpp"

namespace saltus::qp {
namespace {

// rho and delta, in units of the data, in the order of attempts. An early pivot of this size loses
// a relative precision of 1e-16 divided by its size. Refinement recovers it if it converges, which
// fails if rho or delta exceeds the entry that it is added to (1/w of an active row). Hence neither
// the largest nor the smallest value always works.
constexpr std::array regularisations{1e-12, 1e-14, 1e-10, 1e-8, 1e-6};
// Backward error at which a solution is accepted.
constexpr double accurate = 1e-13;
// Rows with a smaller weight have no effect.
constexpr double least_weight = 1e-20;
constexpr int refinements = 10;
// A refinement step that removes less than half of the residual has reached rounding.
constexpr double worthwhile = 0.5;
// Relative to the largest term of a residual: below this nothing is left to remove.
constexpr double rounding = 1e-16;

}  // namespace

bool SparseSystem::factor(const double* weights) {
  best_is_of_factor_ = false;
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

// Variables and rows have different units, and large weights make the terms of the first part
// large. Each residual is therefore relative to the terms of its part.
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
  const double largest_v = largest_entry(v);
  raise(terms_of_variables, scale_ * largest_v);
  raise(terms_of_variables, row_scale_ * largest_entry(p));
  raise(terms_of_rows, row_scale_ * largest_v);
  const double of_variables = largest_entry(residual_.head(n_)),
               of_rows = largest_entry(residual_.tail(m_));
  return std::max(of_variables > 0.0 ? of_variables / terms_of_variables : 0.0,
                  of_rows > 0.0 ? of_rows / terms_of_rows : 0.0);
}

// Solves, refines, and keeps the solution if its error is the smallest so far.
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

  // Tries other regularisations if the solution is poor. The next factorisation starts with the
  // last one tried.
  double smallest = infinity;
  refine(smallest);
  for (std::size_t tried = 1; tried < regularisations.size() && smallest > accurate; ++tried) {
    next_level();
    if (factor_with(regularisations[level_])) refine(smallest);
  }
  best_is_of_factor_ = true;
  for (int i = 0; i < n_; ++i) dv[i] = best_[i];
  for (int i = n_; i < variables(); ++i) dv[i] = 0.0;
  for (std::size_t i = 0; i < equality_rows_.size(); ++i) dy[i] = best_[n_ + equality_rows_[i]];
  for (int i = static_cast<int>(equality_rows_.size()); i < equalities(); ++i) dy[i] = 0.0;
}

}  // namespace saltus::qp
