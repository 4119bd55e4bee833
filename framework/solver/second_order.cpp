#include "saltus/solver/second_order.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "saltus/qp/sparse_ldl.hpp"

namespace saltus {
namespace {

using Verdict = SecondOrderCheck::Verdict;

// Of a scaled matrix, whose entries are at most 1.
constexpr double flat = 1e-6;       // curvature down to minus this is none
constexpr double dependent = 1e-9;  // what keeps the factor finite where rows depend on one another
constexpr double onto_surface = 1e4;  // a shift beside which H does not count: a projection
constexpr double off_surface = 1e-4;  // of a unit direction: beyond it constraints do not allow it
// Distance to a side, relative to its size, that solvers leave of sides that hold.
constexpr double met = 1e-6;

bool meets(double multiplier, double value, double lower, double upper) {
  if (lower == upper) return true;
  const auto at = [&](double side) {
    return std::isfinite(side) &&
           std::abs(value - side) <= std::max(met * (1.0 + std::abs(side)), std::abs(multiplier));
  };
  return at(lower) || at(upper);
}

// The KKT matrix [H + shift, A'; A, -dependent] of the free variables and the rows in force,
// scaled.
class KktMatrix {
 public:
  KktMatrix(NonlinearProgram& program, const NlpPoint& point) : program_(program) {
    is_valid_ = collect(point);
  }
  bool is_valid() const { return is_valid_; }
  int free() const { return static_cast<int>(variable_.size()); }

  /// Whether H + shift is positive definite on the surface of the rows.
  bool is_positive(double shift) {
    for (int i = 0; i < size(); ++i) {
      const int e = pattern_.find(i, i);
      ldl_->set(e, entries_[e] + (i < free() ? shift : -dependent));
    }
    return ldl_->factor_with_inertia();
  }

  /// The direction along which the curvature is least, after is_positive(); of length 1.
  VectorXd least_curved() {
    VectorXd d(size());
    unsigned state = 12345;  // numbers without a pattern, the same in every run
    for (double& x : d) {
      state = state * 1664525u + 1013904223u;
      x = 2.0 * (state >> 8) / (1u << 24) - 1.0;
    }
    for (int round = 0; round < 30; ++round) iterate(d);
    if (is_positive(onto_surface)) iterate(d);
    return d.head(free());
  }

  /// d' H d and |A d|, largest entry, in scaled variables.
  std::pair<double, double> judge(const VectorXd& d) const {
    double curvature = 0.0;
    VectorXd rows = VectorXd::Zero(size() - free());
    pattern_.for_each([&](int i, int j, int e) {
      if (i < free())
        curvature += (i == j ? 1.0 : 2.0) * entries_[e] * d[i] * d[j];
      else if (j < free())
        rows[i - free()] += entries_[e] * d[j];
    });
    return {curvature, rows.size() > 0 ? rows.cwiseAbs().maxCoeff() : 0.0};
  }

  /// In the program's variables, largest entry 1.
  VectorXd in_program(const VectorXd& d, int& variable) const {
    VectorXd result = VectorXd::Zero(program_.variables());
    for (int i = 0; i < free(); ++i) result[variable_[i]] = d[i] * scale_[i];
    Eigen::Index most = 0;
    const double largest = result.cwiseAbs().maxCoeff(&most);
    variable = static_cast<int>(most);
    return result / largest;
  }

 private:
  int size() const { return pattern_.rows(); }

  // The inverse of the shifted matrix on the surface times d, of length 1.
  void iterate(VectorXd& d) {
    d.tail(size() - free()).setZero();
    ldl_->solve(d.data());
    d /= d.head(free()).norm();
  }

  bool collect(const NlpPoint& point) {
    NonlinearProgram& p = program_;
    const SparsityPattern &of_jacobian = p.jacobian_pattern(), &of_hessian = p.hessian_pattern();
    VectorXd g(p.rows());
    std::vector<double> jacobian(of_jacobian.entries()), hessian(of_hessian.entries());
    if (!p.supports(Curvature::exact) || point.lambda.size() != p.rows() ||
        !p.constraints(point.w.data(), g.data()) || !p.jacobian(point.w.data(), jacobian.data()) ||
        !p.hessian(point.w.data(), 1.0, point.lambda.data(), hessian.data(), Curvature::exact))
      return false;
    const bool has_z = point.z.size() == p.variables();
    std::vector<int> unknown(p.variables(), -1), row(p.rows(), -1);
    for (int i = 0; i < p.variables(); ++i)
      if (!meets(has_z ? point.z[i] : 0.0, point.w[i], p.lower()[i], p.upper()[i])) {
        unknown[i] = free();
        variable_.push_back(i);
      }
    std::vector<char> moves(p.rows(), 0);
    of_jacobian.for_each([&](int r, int c, int e) {
      if (unknown[c] >= 0 && jacobian[e] != 0.0) moves[r] = 1;
    });
    int count = free();
    for (int r = 0; r < p.rows(); ++r)
      if (moves[r] && meets(point.lambda[r], g[r], p.row_lower()[r], p.row_upper()[r]))
        row[r] = count++;

    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i < count; ++i) pairs.emplace_back(i, i);
    const auto place = [&](int r, int c) {
      return std::pair(std::max(unknown[r], unknown[c]), std::min(unknown[r], unknown[c]));
    };
    of_hessian.for_each([&](int r, int c, int) {
      if (unknown[r] >= 0 && unknown[c] >= 0) pairs.push_back(place(r, c));
    });
    of_jacobian.for_each([&](int r, int c, int) {
      if (row[r] >= 0 && unknown[c] >= 0) pairs.emplace_back(row[r], unknown[c]);
    });
    pattern_ = SparsityPattern::from_pairs(count, count, std::move(pairs));
    entries_.assign(pattern_.entries(), 0.0);
    of_hessian.for_each([&](int r, int c, int e) {
      if (unknown[r] < 0 || unknown[c] < 0) return;
      const auto [i, j] = place(r, c);
      entries_[pattern_.find(i, j)] += hessian[e];
    });
    of_jacobian.for_each([&](int r, int c, int e) {
      if (row[r] >= 0 && unknown[c] >= 0) entries_[pattern_.find(row[r], unknown[c])] = jacobian[e];
    });
    equilibrate();
    for (const double e : entries_)
      if (!std::isfinite(e)) return false;
    std::vector<signed char> signs(count, -1);
    std::fill(signs.begin(), signs.begin() + free(), static_cast<signed char>(1));
    ldl_.emplace(pattern_, std::move(signs));
    for (int e = 0; e < pattern_.entries(); ++e) ldl_->set(e, entries_[e]);
    return true;
  }

  // Rows and columns are scaled alike until their largest entries are about 1 (Ruiz).
  void equilibrate() {
    scale_ = VectorXd::Ones(size());
    for (int round = 0; round < 6; ++round) {
      VectorXd largest = VectorXd::Zero(size());
      pattern_.for_each([&](int i, int j, int e) {
        largest[i] = std::max(largest[i], std::abs(entries_[e]));
        largest[j] = std::max(largest[j], std::abs(entries_[e]));
      });
      for (double& s : largest) s = s > 0.0 ? 1.0 / std::sqrt(s) : 1.0;
      pattern_.for_each([&](int i, int j, int e) { entries_[e] *= largest[i] * largest[j]; });
      scale_ = scale_.cwiseProduct(largest);
    }
  }

  NonlinearProgram& program_;
  bool is_valid_ = false;
  std::vector<int> variable_;  // of the program, of each unknown
  SparsityPattern pattern_;    // lower triangle
  std::vector<double> entries_;
  VectorXd scale_;
  std::optional<qp::SparseLdl> ldl_;
};

// The least shift that makes the matrix positive, to a tenth; none up to 100.
std::optional<double> least_shift(KktMatrix& matrix) {
  double above = 10.0 * flat, below = flat;
  while (!matrix.is_positive(above)) {
    below = above;
    above *= 10.0;
    if (above > 100.0) return std::nullopt;
  }
  while (above > 1.1 * below) {
    const double middle = std::sqrt(above * below);
    (matrix.is_positive(middle) ? above : below) = middle;
  }
  return above;
}

}  // namespace

SecondOrderCheck check_second_order(NonlinearProgram& program, const NlpPoint& point) {
  SecondOrderCheck result;
  KktMatrix matrix(program, point);
  if (!matrix.is_valid()) return result;
  if (matrix.free() == 0 || matrix.is_positive(flat)) {
    result.verdict = Verdict::no_descent;
    return result;
  }
  const std::optional<double> shift = least_shift(matrix);
  if (!shift || !matrix.is_positive(*shift)) return result;
  const VectorXd d = matrix.least_curved();
  const auto [curvature, off] = matrix.judge(d);
  if (!d.allFinite() || off > off_surface || !(curvature < -flat)) return result;
  result.verdict = Verdict::descent;
  result.direction = matrix.in_program(d, result.variable);
  result.curvature = curvature;
  return result;
}

}  // namespace saltus
