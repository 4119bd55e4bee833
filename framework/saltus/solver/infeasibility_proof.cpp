// Affine rows g = J w + c between sides l <= g <= u, and bounds lower <= w <= upper. For every
// lambda and every point that satisfies them,
//
//     sum_i min(r_i lower_i, r_i upper_i) + lambda'c  <=  lambda'g
//                                                     <=  sum_k max(lambda_k l_k, lambda_k u_k),
//
// where r = J'lambda. If the left side exceeds the right side, there is no such point (Farkas).
// Candidates for lambda are the multipliers of the least violation,
//
//     min 1/2 |s|^2   subject to   l <= J w + c + s <= u,   lower <= w <= upper.
//
// Variables without a bound require r_i = 0. The multipliers of a solver leave small residuals r_i.
// They are projected onto J_F'lambda = 0, where F are the variables away from their bounds. A
// residual counts as zero only if it is at the rounding level of its own terms, |r_i| <= rounding *
// sum_k |J_ki lambda_k|. This test does not depend on the units of rows and variables, so small
// gains prove nothing.
#include "saltus/solver/infeasibility_proof.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/sparse_ldl.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus {
namespace {

constexpr double rounding = 1e-12;  // error of a sum, relative to the sizes of its terms
constexpr double decisive = 1e-9;   // least contradiction, relative to the magnitudes of its terms
constexpr int equilibrations = 20, projections = 5;
constexpr double least_multiplier = 1e-9;  // relative to the largest: smaller ones are zero
constexpr double at_bound = 1e-6;          // a variable is at its bound, in equilibrated units
constexpr double regularisation = 1e-12;   // for linearly dependent rows

class Proof {
 public:
  Proof(NonlinearProgram& program, const VectorXd& w)
      : n_(program.variables()), m_(program.rows()), pattern_(program.jacobian_pattern()) {
    entries_.resize(pattern_.entries());
    lower_ = program.lower();
    upper_ = program.upper();
    row_lower_ = program.row_lower();
    row_upper_ = program.row_upper();
    // Near zero the constants lose no digits, but nonlinear rows may have no value there.
    const VectorXd origin = VectorXd::Zero(n_).cwiseMax(lower_).cwiseMin(upper_);
    is_usable_ = evaluate(program, origin) || (w.size() == n_ && evaluate(program, w));
    if (!is_usable_) return;
    for (int k = 0; k < m_; ++k) {
      if (program.is_affine(k) && std::isfinite(constant_[k])) continue;
      row_lower_[k] = -infinity;
      row_upper_[k] = infinity;
    }
    for (VectorXd* sides : {&lower_, &row_lower_})
      for (double& side : *sides)
        if (side <= -no_bound) side = -infinity;
    for (VectorXd* sides : {&upper_, &row_upper_})
      for (double& side : *sides)
        if (side >= no_bound) side = infinity;
    is_usable_ = is_sided_any();
  }

  bool succeeds() {
    if (!is_usable_) return false;
    equilibrate();
    if (!find_multipliers()) return false;
    for (int round = 0; round < projections; ++round) {
      if (contradicts()) return true;
      if (!project()) return false;
    }
    return contradicts();
  }

 private:
  bool is_sided(int k) const { return row_lower_[k] > -infinity || row_upper_[k] < infinity; }
  bool is_sided_any() const {
    for (int k = 0; k < m_; ++k)
      if (is_sided(k)) return true;
    return false;
  }
  bool is_fixed(int i) const { return lower_[i] == upper_[i]; }
  double scaled(int k, int i, int e) const { return row_unit_[k] * entries_[e] * unit_[i]; }

  bool evaluate(NonlinearProgram& program, const VectorXd& w) {
    constant_ = VectorXd::Zero(m_);
    if (!w.allFinite() || !program.constraints(w.data(), constant_.data()) ||
        !program.jacobian(w.data(), entries_.data()) || !entries_.allFinite())
      return false;
    pattern_.for_each([&](int k, int i, int e) { constant_[k] -= entries_[e] * w[i]; });
    return true;
  }

  // Finds units of rows and variables in which the logarithms of the entries of each average to
  // zero.
  void equilibrate() {
    row_unit_ = VectorXd::Ones(m_);
    unit_ = VectorXd::Ones(n_);
    VectorXd sum(std::max(m_, n_)), count(std::max(m_, n_));
    const auto divide = [&](VectorXd& units, bool by_row) {
      sum.setZero();
      count.setZero();
      pattern_.for_each([&](int k, int i, int e) {
        if (is_fixed(i) || !is_sided(k) || entries_[e] == 0.0) return;
        sum[by_row ? k : i] += std::log(std::abs(scaled(k, i, e)));
        count[by_row ? k : i] += 1.0;
      });
      for (int j = 0; j < units.size(); ++j)
        if (count[j] > 0.0) units[j] *= std::exp(-sum[j] / count[j]);
    };
    for (int round = 0; round < equilibrations; ++round) {
      divide(row_unit_, true);
      divide(unit_, false);
    }
  }

  // Finds the multipliers of the least violation. Returns false if the rows can be satisfied or the
  // solver fails.
  bool find_multipliers() {
    std::vector<std::pair<int, int>> rows, hessian;
    pattern_.for_each([&](int k, int i, int) { rows.emplace_back(k, i); });
    for (int k = 0; k < m_; ++k) {
      rows.emplace_back(k, n_ + k);
      hessian.emplace_back(n_ + k, n_ + k);
    }
    qp::SparseQp qp(SparsityPattern::from_pairs(n_ + m_, n_ + m_, std::move(hessian)),
                    SparsityPattern::from_pairs(m_, n_ + m_, std::move(rows)));
    qp.hessian.setOnes();
    pattern_.for_each(
        [&](int k, int i, int e) { qp.rows[qp.row_pattern.find(k, i)] = scaled(k, i, e); });
    for (int k = 0; k < m_; ++k) {
      qp.rows[qp.row_pattern.find(k, n_ + k)] = 1.0;
      qp.row_lower[k] = row_unit_[k] * (row_lower_[k] - constant_[k]);
      qp.row_upper[k] = row_unit_[k] * (row_upper_[k] - constant_[k]);
    }
    qp.lower.head(n_) = lower_.cwiseQuotient(unit_);
    qp.upper.head(n_) = upper_.cwiseQuotient(unit_);
    const auto divide_sides = [&](double size) {
      for (VectorXd* sides : {&qp.row_lower, &qp.row_upper, &qp.lower, &qp.upper}) *sides /= size;
    };
    double size = 0.0;
    for (const VectorXd* sides : {&qp.row_lower, &qp.row_upper, &qp.lower, &qp.upper})
      for (const double side : *sides)
        if (std::isfinite(side)) size = std::max(size, std::abs(side));
    if (!(size > 0.0)) return false;
    divide_sides(size);
    PrimalDualPoint point{VectorXd::Zero(n_ + m_), VectorXd::Zero(m_), VectorXd::Zero(n_ + m_)};
    const auto solver =
        qp::make_sparse_qp_solver(qp.hessian_pattern, qp.row_pattern, {.tolerance = 1e-10});
    solver->solve(qp, point, false);
    // Solve again with sides of the size of the violation, because the tolerance is absolute.
    const double missing = point.lambda.lpNorm<Eigen::Infinity>();
    if (!(missing > 1e-9) || !std::isfinite(missing)) return false;
    divide_sides(missing);
    point.w /= missing;
    solver->solve(qp, point, false);
    lambda_ = point.lambda;
    is_free_.assign(n_, 0);
    for (int i = 0; i < n_; ++i)
      is_free_[i] = !is_fixed(i) && point.w[i] - qp.lower[i] > at_bound &&
                    qp.upper[i] - point.w[i] > at_bound;
    const double most = lambda_.cwiseAbs().maxCoeff();
    if (!(most > 0.0) || !lambda_.allFinite()) return false;
    for (int k = 0; k < m_; ++k) {
      const bool has_side = lambda_[k] > 0.0 ? row_upper_[k] < infinity : row_lower_[k] > -infinity;
      if (!has_side || std::abs(lambda_[k]) <= least_multiplier * most) lambda_[k] = 0.0;
    }
    return true;
  }

  // Projects to the nearest multipliers, relative to their sizes, with J_F'lambda = 0.
  bool project() {
    if (ldl_ == nullptr) {
      std::vector<std::pair<int, int>> entries;
      entries.reserve(m_ + n_ + pattern_.entries());
      for (int i = 0; i < m_ + n_; ++i) entries.emplace_back(i, i);
      pattern_.for_each([&](int k, int i, int) { entries.emplace_back(m_ + i, k); });
      system_ = SparsityPattern::from_pairs(m_ + n_, m_ + n_, std::move(entries));
      std::vector<signed char> signs(m_ + n_, 1);
      std::fill(signs.begin() + m_, signs.end(), static_cast<signed char>(-1));
      ldl_ = std::make_unique<qp::SparseLdl>(system_, std::move(signs));
    }
    for (int k = 0; k < m_; ++k) ldl_->set(system_.find(k, k), 1.0);
    for (int i = 0; i < n_; ++i)
      ldl_->set(system_.find(m_ + i, m_ + i), is_free_[i] ? -regularisation : -1.0);
    VectorXd rest = VectorXd::Zero(m_ + n_);
    pattern_.for_each([&](int k, int i, int e) {
      ldl_->set(system_.find(m_ + i, k),
                is_free_[i] ? scaled(k, i, e) * std::abs(lambda_[k]) : 0.0);
      if (is_free_[i]) rest[m_ + i] -= scaled(k, i, e) * lambda_[k];
    });
    if (!ldl_->factor()) return false;
    ldl_->solve(rest.data());
    for (int k = 0; k < m_; ++k) {
      const double next = lambda_[k] + std::abs(lambda_[k]) * rest[k];
      // Multipliers of inequalities keep their signs.
      if (row_lower_[k] == row_upper_[k] || next * lambda_[k] > 0.0) lambda_[k] = next;
    }
    return lambda_.allFinite();
  }

  bool contradicts() const {
    VectorXd rest = VectorXd::Zero(n_), terms = VectorXd::Zero(n_);
    pattern_.for_each([&](int k, int i, int e) {
      const double term = row_unit_[k] * lambda_[k] * entries_[e];
      rest[i] += term;
      terms[i] += std::abs(term);
    });
    double missing = 0.0, size = 0.0;
    const auto add = [&](double term) {
      missing += term;
      size += std::abs(term);
    };
    for (int i = 0; i < n_; ++i) {
      if (std::abs(rest[i]) <= rounding * terms[i]) continue;
      const double bound = rest[i] > 0.0 ? lower_[i] : upper_[i];
      if (!std::isfinite(bound)) return false;
      add(rest[i] * bound);
    }
    for (int k = 0; k < m_; ++k) {
      const double multiplier = row_unit_[k] * lambda_[k];
      if (multiplier == 0.0) continue;
      add(multiplier * constant_[k]);
      add(-multiplier * (multiplier > 0.0 ? row_upper_[k] : row_lower_[k]));
    }
    return missing > decisive * size;
  }

  int n_, m_;
  const SparsityPattern& pattern_;
  VectorXd entries_, constant_, lower_, upper_, row_lower_, row_upper_;
  VectorXd row_unit_, unit_;
  VectorXd lambda_;  // in equilibrated units of the rows
  std::vector<char> is_free_;
  bool is_usable_ = false;
  SparsityPattern system_;
  std::unique_ptr<qp::SparseLdl> ldl_;
};

}  // namespace

bool is_proved_infeasible(NonlinearProgram& program, const VectorXd& w) {
  return program.rows() > 0 && Proof(program, w).succeeds();
}

}  // namespace saltus
