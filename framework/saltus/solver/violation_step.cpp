#include "saltus/solver/violation_step.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "saltus/qp/sparse_ldl.hpp"

namespace saltus {
namespace {

constexpr int most_steps = 10;
constexpr int most_rounds = 20;  // per step, to find the variables at bounds
constexpr double enough = 0.5;   // required fraction of the violation
// Keeps the factor finite if rows are dependent. The smaller value is tried first: it hardly
// changes steps along small derivatives.
constexpr double dependent[] = {1e-13, 1e-9};
constexpr double least_size = 1e-6;   // per variable, relative to the largest movement
constexpr double violated = 1e-12;    // relative to 1 + |side|: larger violations are corrected
constexpr double worthwhile = 1e-10;  // relative violation at which the steps end

// Rows and their derivatives at a point, and the distance of each row from its sides.
struct Rows {
  VectorXd values, entries, gap;
  bool evaluate(NonlinearProgram& p, const VectorXd& w) {
    values.resize(p.rows());
    entries.resize(p.jacobian_pattern().entries());
    if (!p.constraints(w.data(), values.data()) || !p.jacobian(w.data(), entries.data()) ||
        !values.allFinite() || !entries.allFinite())
      return false;
    gap.resize(p.rows());
    for (int r = 0; r < p.rows(); ++r)
      gap[r] =
          std::max(p.row_lower()[r] - values[r], 0.0) - std::max(values[r] - p.row_upper()[r], 0.0);
    return true;
  }
};

class Steps {
 public:
  Steps(NonlinearProgram& program, const Rows& at) : p_(program) {
    const int n = p_.variables(), m = p_.rows();
    way_ = size_ = derivative_ = VectorXd::Zero(n);
    p_.jacobian_pattern().for_each([&](int, int c, int e) {
      if (p_.lower()[c] < p_.upper()[c])
        derivative_[c] = std::max(derivative_[c], std::abs(at.entries[e]));
    });
    for (int i = 0; i < n; ++i) size_[i] = derivative_[i] == 0.0 ? 0.0 : 1.0 / derivative_[i];
    weight_ = weights_of_rows(at);
    std::vector<std::pair<int, int>> entries;
    entries.reserve(n + m + p_.jacobian_pattern().entries());
    for (int i = 0; i < n + m; ++i) entries.emplace_back(i, i);
    p_.jacobian_pattern().for_each([&](int r, int c, int) { entries.emplace_back(n + r, c); });
    pattern_ = SparsityPattern::from_pairs(n + m, n + m, std::move(entries));
    std::vector<signed char> signs(n + m, 1);
    std::fill(signs.begin() + n, signs.end(), static_cast<signed char>(-1));
    ldl_ = std::make_unique<qp::SparseLdl>(pattern_, std::move(signs));
  }

  double violation(const Rows& at) const { return at.gap.cwiseProduct(weight_).lpNorm<1>(); }

  /// The point after a step from w, within the bounds. Empty if the factorisation fails.
  std::optional<VectorXd> next(const VectorXd& w, const Rows& at, double shift) {
    const int n = p_.variables();
    const VectorXd row = weights_of_rows(at);
    // A variable that would leave its bounds is held at the bound, and the step of the others is
    // computed again. Otherwise clipping would break the rows that the step meets.
    VectorXd held = VectorXd::Zero(n), step;
    for (int round = 0; round < most_rounds; ++round) {
      if (!solve(at, row, held, shift, step)) return std::nullopt;
      bool is_inside = true;
      for (int i = 0; i < n; ++i) {
        const double inside = std::clamp(w[i] + step[i], p_.lower()[i], p_.upper()[i]);
        if (size_[i] == 0.0 || inside == w[i] + step[i]) continue;
        held[i] = inside - w[i];
        size_[i] = derivative_[i] = 0.0;
        is_inside = false;
      }
      if (is_inside) break;
    }
    VectorXd result = w + held + step;
    if (!result.allFinite()) return std::nullopt;
    // The next step is the shortest one in units of the movement so far. Variables that have
    // reached a bound keep their values.
    way_ += step;
    const VectorXd units = way_.cwiseAbs().cwiseProduct(derivative_);
    for (int i = 0; i < n; ++i) {
      result[i] = std::clamp(result[i], p_.lower()[i], p_.upper()[i]);
      size_[i] = derivative_[i] == 0.0
                     ? 0.0
                     : std::max(units[i], least_size * units.maxCoeff()) / derivative_[i];
    }
    return result;
  }

 private:
  // The shortest step, in units of size_, that meets the linearised rows if the variables without a
  // size move by `held`.
  bool solve(const Rows& at, const VectorXd& row, const VectorXd& held, double shift,
             VectorXd& step) {
    const int n = p_.variables(), m = p_.rows();
    const auto is_aimed_at = [&](int r) {
      return p_.row_lower()[r] == p_.row_upper()[r] ||
             std::abs(at.gap[r]) > violated * (1.0 + std::abs(at.values[r]));
    };
    VectorXd unknowns = VectorXd::Zero(n + m), gap = at.gap;
    p_.jacobian_pattern().for_each([&](int r, int c, int e) {
      gap[r] -= at.entries[e] * held[c];
      const double scaled = at.entries[e] * size_[c] * row[r];
      ldl_->set(pattern_.find(n + r, c), is_aimed_at(r) ? scaled : 0.0);
    });
    for (int i = 0; i < n; ++i) ldl_->set(pattern_.find(i, i), 1.0);
    for (int r = 0; r < m; ++r) {
      ldl_->set(pattern_.find(n + r, n + r), is_aimed_at(r) ? -shift : -1.0);
      if (is_aimed_at(r)) unknowns[n + r] = gap[r] * row[r];
    }
    if (!ldl_->factor()) return false;
    ldl_->solve(unknowns.data());
    step = unknowns.head(n).cwiseProduct(size_);
    return true;
  }

  VectorXd weights_of_rows(const Rows& at) const {
    VectorXd weights = VectorXd::Zero(p_.rows());
    p_.jacobian_pattern().for_each([&](int r, int c, int e) {
      weights[r] = std::max(weights[r], std::abs(at.entries[e] * size_[c]));
    });
    for (double& weight : weights) weight = weight == 0.0 ? 1.0 : 1.0 / weight;
    return weights;
  }

  NonlinearProgram& p_;
  VectorXd derivative_;  // largest derivative by each variable; 0: the variable is fixed
  VectorXd size_;        // scale of the steps of each variable; 0: it is fixed
  VectorXd way_;         // total movement of each variable
  VectorXd weight_;      // weight of each row in the violation
  SparsityPattern pattern_;
  std::unique_ptr<qp::SparseLdl> ldl_;
};

}  // namespace

std::optional<VectorXd> step_towards_rows(NonlinearProgram& program, const VectorXd& w) {
  Rows at;
  if (w.size() != program.variables() || program.rows() == 0 || !at.evaluate(program, w))
    return std::nullopt;
  Steps steps(program, at);
  const double first = steps.violation(at);
  double least = first;
  VectorXd best = w;
  for (const double shift : dependent) {
    for (int k = 0; k < most_steps && least > worthwhile * first; ++k) {
      const std::optional<VectorXd> next = steps.next(best, at, shift);
      Rows there;
      if (!next || !there.evaluate(program, *next) || !(steps.violation(there) < least)) break;
      best = *next;
      at = std::move(there);
      least = steps.violation(at);
    }
    if (least <= enough * first) break;
  }
  if (!(least <= enough * first)) return std::nullopt;
  return best;
}

}  // namespace saltus
