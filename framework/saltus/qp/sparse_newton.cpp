// One quasi-definite matrix whose pattern covers all cases. Static regularisation rho and delta on
// its diagonals replaces pivoting, and refinement corrects its effect. If no regularisation works
// because rows are nearly dependent, a factorisation with pivoting is used, which takes several
// times as long.
#include "saltus/qp/sparse_newton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "saltus/qp/sparse_indefinite.hpp"
#include "saltus/qp/sparse_ldl.hpp"

namespace saltus::qp {
namespace {

// In units of the data, in the order of attempts (see sparse_factor.cpp).
constexpr std::array regularisations{1e-10, 1e-12, 1e-8, 1e-14, 1e-6};
// Pivots are at least this times the entries that they divide.
constexpr double pivot_threshold = 1e-6;
// Rows with a smaller weight have no effect.
constexpr double least_weight = 1e-20;

// Pairs every row with the free variable of fewest entries. For a row of the dynamics that is the
// state it defines.
std::vector<std::pair<int, int>> pairs_of(const SparsityPattern& hessian,
                                          const SparsityPattern& rows) {
  std::vector<int> degree(rows.cols(), 0);
  hessian.for_each([&](int i, int j, int) {
    ++degree[i];
    ++degree[j];
  });
  rows.for_each([&](int, int j, int) { ++degree[j]; });
  std::vector<char> is_free(rows.cols(), 1);
  std::vector<std::pair<int, int>> pairs;
  for (int i = rows.rows() - 1; i >= 0; --i) {
    int best = -1;
    for (int e = rows.row_begin(i); e < rows.row_end(i); ++e) {
      const int j = rows.col(e);
      if (is_free[j] && (best < 0 || degree[j] <= degree[best])) best = j;
    }
    if (best < 0) continue;
    is_free[best] = 0;
    pairs.emplace_back(best, rows.cols() + i);
  }
  return pairs;
}

class SparseNewton final : public NewtonSystem {
 public:
  SparseNewton(const SparsityPattern& hessian, const SparsityPattern& rows)
      : n_(rows.cols()),
        m_(rows.rows()),
        hessian_pattern_(hessian),
        row_pattern_(rows),
        ldl_(quasi_definite_pattern(hessian, rows), quasi_definite_signs(n_, m_)),
        diagonal_(VectorXd::Zero(n_ + m_)),
        weighted_(VectorXd::Zero(n_ + m_)),
        work_(VectorXd::Zero(n_ + m_)),
        is_fixed_(n_, 0),
        has_free_(m_, 0) {
    const SparsityPattern pattern = quasi_definite_pattern(hessian, rows);
    hessian.for_each([&](int i, int j, int) { hessian_slot_.push_back(pattern.find(i, j)); });
    rows.for_each([&](int i, int j, int) { row_slot_.push_back(pattern.find(n_ + i, j)); });
    for (int i = 0; i < n_ + m_; ++i) diagonal_slot_.push_back(pattern.find(i, i));
  }

  void restart() override { level_ = 0; }

  bool load(const SparseQp& qp) override {
    qp_ = &qp;
    if (!qp.hessian.allFinite() || !qp.rows.allFinite()) return false;
    for (int i = 0; i < n_; ++i) is_fixed_[i] = qp.lower[i] == qp.upper[i];
    diagonal_.setZero();
    scale_ = 1.0;
    hessian_pattern_.for_each([&](int i, int j, int e) {
      const double value = is_fixed_[i] || is_fixed_[j] ? 0.0 : qp.hessian[e];
      scale_ = std::max(scale_, std::abs(value));
      if (i == j)
        diagonal_[i] = value;
      else
        ldl_.set(hessian_slot_[e], value);
    });
    row_pattern_.for_each(
        [&](int, int j, int e) { ldl_.set(row_slot_[e], is_fixed_[j] ? 0.0 : qp.rows[e]); });
    return true;
  }

  bool factor(const VectorXd& variable_weights, const VectorXd& row_weights) override {
    tried_ = 0;
    by_pivots_ = false;
    for (int i = 0; i < n_; ++i)
      weighted_[i] = is_fixed_[i] ? 1.0 : diagonal_[i] + variable_weights[i];
    for (int i = 0; i < m_; ++i) weighted_[n_ + i] = -1.0 / std::max(row_weights[i], least_weight);
    return factor_with(regularisations[level_]);
  }

  bool factor_with_fallback() override {
    while (++tried_ < regularisations.size()) {
      level_ = (level_ + 1) % regularisations.size();
      if (factor_with(regularisations[level_])) return true;
    }
    if (tried_ > regularisations.size()) return false;
    by_pivots_ = factor_with_pivots();
    return by_pivots_;
  }

  void solve(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda) override {
    work_.head(n_) = -rw;
    work_.tail(m_) = -rr;
    for (int i = 0; i < n_; ++i)
      if (is_fixed_[i]) work_[i] = 0.0;
    if (by_pivots_)
      pivoting_->solve(work_.data());
    else
      ldl_.solve(work_.data());
    dw = work_.head(n_);
    dlambda = work_.tail(m_);
  }

 private:
  bool factor_with(double regularisation) {
    const double rho = regularisation * scale_;
    for (int i = 0; i < n_; ++i) ldl_.set(diagonal_slot_[i], weighted_[i] + rho);
    for (int i = n_; i < n_ + m_; ++i) ldl_.set(diagonal_slot_[i], weighted_[i] - regularisation);
    return ldl_.factor_with_inertia();
  }

  bool factor_with_pivots() {
    if (pivoting_ == nullptr)
      pivoting_ =
          std::make_unique<SparseIndefinite>(quasi_definite_pattern(hessian_pattern_, row_pattern_),
                                             pairs_of(hessian_pattern_, row_pattern_));
    hessian_pattern_.for_each([&](int i, int j, int e) {
      if (i != j)
        pivoting_->set(hessian_slot_[e], is_fixed_[i] || is_fixed_[j] ? 0.0 : qp_->hessian[e]);
    });
    std::fill(has_free_.begin(), has_free_.end(), 0);
    row_pattern_.for_each([&](int i, int j, int e) {
      pivoting_->set(row_slot_[e], is_fixed_[j] ? 0.0 : qp_->rows[e]);
      if (!is_fixed_[j]) has_free_[i] = 1;
    });
    for (int i = 0; i < n_; ++i) pivoting_->set(diagonal_slot_[i], weighted_[i]);
    // A row that contains only fixed variables would be zero in the matrix.
    for (int i = 0; i < m_; ++i)
      pivoting_->set(diagonal_slot_[n_ + i],
                     has_free_[i] || weighted_[n_ + i] < 0.0 ? weighted_[n_ + i] : -1.0);
    return pivoting_->factor(pivot_threshold) && pivoting_->negative() == m_;
  }

  int n_, m_;
  SparsityPattern hessian_pattern_, row_pattern_;
  SparseLdl ldl_;
  std::vector<int> hessian_slot_, row_slot_, diagonal_slot_;  // positions in the matrix pattern
  VectorXd diagonal_;                                         // diagonal of H, then zeros
  VectorXd weighted_;                                         // diagonal_ plus the weights
  VectorXd work_;
  const SparseQp* qp_ = nullptr;
  std::unique_ptr<SparseIndefinite> pivoting_;  // created when first needed
  bool by_pivots_ = false;
  std::vector<char> is_fixed_, has_free_;  // per variable; per row: true if any variable is free
  double scale_ = 1.0;                     // largest entry of H, at least 1: the unit of rho
  std::size_t level_ = 0, tried_ = 0;      // indices of the regularisations
};

}  // namespace

std::unique_ptr<NewtonSystem> make_sparse_newton(const SparsityPattern& hessian,
                                                 const SparsityPattern& rows) {
  return std::make_unique<SparseNewton>(hessian, rows);
}

}  // namespace saltus::qp
