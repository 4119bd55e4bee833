#include "saltus/solver/optimum_check.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/sparse_ldl.hpp"

namespace saltus {
namespace {

using Verdict = OptimumCheck::Curvature;

// Entries of H and A in the scaled matrix are at most 1.
constexpr double flat = 1e-6;         // smaller magnitudes of curvature count as zero
constexpr double small = 1e-3;        // entries of H below this size may be lost in the shift
constexpr double dependent = 1e-9;    // keeps the factor finite if rows are dependent
constexpr double onto_surface = 1e4;  // shift that dominates H: a projection
// for unit directions: larger components violate the constraints
constexpr double off_surface = 1e-4;
// Relative to the change of a row by a step: smaller values are errors of the factorisation.
constexpr double noise = 1e-2;
// A side without a multiplier is active within this distance, relative to 1 + |side|.
constexpr double touching = 1e-9;
// Allowed increase of the violation of a row by a step that tests the cost.
constexpr double off_rows = 1e-8;
// Weight of a side in the scaled matrix above which it acts as an equality.
constexpr double holds = 1e9;
// Lower limit of the reference magnitude of a cost near zero.
constexpr double least_magnitude = 1.0;
constexpr double zero = 1e-7;  // largest value that solvers leave of a zero

// The side of a variable or row that its multiplier pushes against.
struct Side {
  bool is_equality = false;
  bool is_wrong = false;    // there is no side in the direction of the multiplier
  double distance = 0.0;    // to the side; infinite if there is none
  double multiplier = 0.0;  // its magnitude
  // Multiplier over distance: 0 if the side is inactive, infinite if it acts as an equality.
  double weight() const {
    if (is_equality) return infinity;
    if (multiplier == 0.0 || is_wrong) return distance <= 0.0 ? infinity : 0.0;
    return distance <= 0.0 ? infinity : multiplier / distance;
  }
};

Side side_of(double multiplier, double value, double lower, double upper) {
  if (lower == upper) return {.is_equality = true};
  const auto distance = [](double inside, double side) {
    return inside <= touching * (1.0 + std::abs(side)) ? 0.0 : inside;
  };
  const double below = std::isfinite(lower) ? distance(value - lower, lower) : infinity;
  const double above = std::isfinite(upper) ? distance(upper - value, upper) : infinity;
  if (multiplier == 0.0) return {.distance = std::min(below, above)};
  const double d = multiplier > 0.0 ? above : below;
  return {.is_wrong = d == infinity, .distance = d, .multiplier = std::abs(multiplier)};
}

// Cost, rows and derivatives of the program at a point.
struct Evaluation {
  double cost = 0.0;
  VectorXd gradient, rows, jacobian, hessian;
  VectorXd residual;  // gradient of the Lagrangian
  std::vector<Side> of_variable, of_row;
  bool has_hessian = false;
};

bool evaluate(NonlinearProgram& p, const NlpPoint& point, Evaluation& e) {
  const int n = p.variables(), m = p.rows();
  e.gradient.resize(n);
  e.rows.resize(m);
  e.jacobian.resize(p.jacobian_pattern().entries());
  e.hessian.resize(p.hessian_pattern().entries());
  if (point.w.size() != n || point.lambda.size() != m || point.z.size() != n ||
      !point.w.allFinite() || !point.lambda.allFinite() || !point.z.allFinite() ||
      !p.objective(point.w.data(), e.cost) || !p.gradient(point.w.data(), e.gradient.data()) ||
      !p.constraints(point.w.data(), e.rows.data()) ||
      !p.jacobian(point.w.data(), e.jacobian.data()) || !std::isfinite(e.cost) ||
      !e.gradient.allFinite() || !e.rows.allFinite() || !e.jacobian.allFinite())
    return false;
  e.residual = e.gradient;
  p.jacobian_pattern().for_each(
      [&](int r, int c, int k) { e.residual[c] += point.lambda[r] * e.jacobian[k]; });
  for (int i = 0; i < n; ++i) {
    e.of_variable.push_back(side_of(point.z[i], point.w[i], p.lower()[i], p.upper()[i]));
    if (e.of_variable[i].is_equality)
      e.residual[i] = 0.0;
    else if (!e.of_variable[i].is_wrong)
      e.residual[i] += point.z[i];
  }
  for (int r = 0; r < m; ++r)
    e.of_row.push_back(side_of(point.lambda[r], e.rows[r], p.row_lower()[r], p.row_upper()[r]));
  e.has_hessian =
      p.supports(Curvature::exact) &&
      p.hessian(point.w.data(), 1.0, point.lambda.data(), e.hessian.data(), Curvature::exact) &&
      e.hessian.allFinite();
  return true;
}

// Size of each variable: the largest value of its quantity. If all values are within the solver's
// error of zero, the size is estimated through the rows. It is 1 if no row gives an estimate, and
// for variables without a quantity.
VectorXd sizes_of(const NonlinearProgram& p, const VectorXd& w, const VectorXd& jacobian,
                  const Quantities& quantities) {
  std::vector<int> quantity_of(p.variables(), -1);
  VectorXd size = VectorXd::Zero(static_cast<Eigen::Index>(quantities.size()));
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    for (const int v : quantities[q]) {
      quantity_of[v] = static_cast<int>(q);
      if (std::abs(w[v]) > zero) size[q] = std::max(size[q], std::abs(w[v]));
    }
  }
  size = estimate_sizes_from_rows(p, jacobian, quantity_of, std::move(size));
  VectorXd sizes = VectorXd::Ones(p.variables());
  for (int v = 0; v < p.variables(); ++v)
    if (quantity_of[v] >= 0 && size[quantity_of[v]] > 0.0) sizes[v] = size[quantity_of[v]];
  return sizes;
}

// Largest change of the cost if one variable moves by its size. Slacks count only if no other
// variable changes the cost: penalty weights are not sizes.
double change_of_cost(const NonlinearProgram& p, const Evaluation& e, const VectorXd& sizes) {
  const int first_slack = p.first_slack();
  VectorXd change = (e.gradient.array() * sizes.array()).abs().matrix();
  if (e.has_hessian)
    p.hessian_pattern().for_each([&](int i, int j, int k) {
      if (i == j) change[i] += 0.5 * std::abs(e.hessian[k]) * sizes[i] * sizes[i];
    });
  const double largest = first_slack > 0 ? change.head(first_slack).maxCoeff() : 0.0;
  return largest > 0.0 || change.size() == 0 ? largest : change.maxCoeff();
}

// Largest change of the Lagrangian, to first order, if one variable moves by its size or by its
// value. Where second derivatives vanish, no step of Newton's method predicts a decrease.
double gain_of_one_variable(const NlpPoint& point, const Evaluation& at, const VectorXd& sizes) {
  return (at.residual.array() * sizes.array().max(point.w.array().abs())).abs().maxCoeff();
}

// The scaled KKT matrix [H + Z/G + shift, A'; A, -G/L - dependent] of the free variables and active
// rows.
class KktMatrix {
 public:
  KktMatrix(NonlinearProgram& program, const Evaluation& at) : program_(program) {
    is_valid_ = collect(at);
  }
  bool is_valid() const { return is_valid_; }
  int free() const { return static_cast<int>(variable_.size()); }
  /// Largest magnitude of the entries of H.
  double largest_curvature() const { return largest_curvature_; }

  /// True if H + Z/G + shift is positive definite on the tangent space of the rows.
  bool is_positive(double shift) {
    for (int i = 0; i < size(); ++i) {
      const int e = pattern_.find(i, i);
      ldl_->set(e, entries_[e] + (i < free() ? shift : -dependent));
    }
    return ldl_->factor_with_inertia();
  }

  /// Predicted decrease of the cost by the step that removes the residual. Call after
  /// is_positive().
  double gain(const VectorXd& residual) {
    VectorXd step = VectorXd::Zero(size());
    for (int i = 0; i < free(); ++i) step[i] = residual[variable_[i]] * scale_[i];
    const VectorXd scaled = step.head(free());
    ldl_->solve(step.data());
    return 0.5 * std::abs(scaled.dot(step.head(free())));
  }

  /// Direction of least curvature, of length 1. Call after is_positive().
  VectorXd least_curvature_direction() {
    VectorXd d(size());
    unsigned state = 12345;  // a deterministic pseudorandom sequence
    for (double& x : d) {
      state = state * 1664525u + 1013904223u;
      x = 2.0 * (state >> 8) / (1u << 24) - 1.0;
    }
    for (int round = 0; round < 30; ++round) iterate(d);
    if (is_positive(onto_surface)) iterate(d);
    return d.head(free());
  }

  /// Curvature along d and its largest component across equality rows, in scaled variables.
  std::pair<double, double> judge(const VectorXd& d) const {
    double curvature = 0.0, off = 0.0;
    VectorXd rows = VectorXd::Zero(size() - free()), room = rows;
    pattern_.for_each([&](int i, int j, int e) {
      if (i < free())
        curvature += (i == j ? 1.0 : 2.0) * entries_[e] * d[i] * d[j];
      else if (j < free())
        rows[i - free()] += entries_[e] * d[j];
      else
        room[i - free()] = -entries_[e];
    });
    for (int r = 0; r < rows.size(); ++r) {
      if (room[r] > 0.0)
        curvature += rows[r] * rows[r] / room[r];
      else
        off = std::max(off, std::abs(rows[r]));
    }
    return {curvature, off};
  }

  /// The direction in the program's variables, largest entry 1. `curvature` is rescaled
  /// accordingly.
  VectorXd in_program(const VectorXd& d, int& variable, double& curvature) const {
    VectorXd result = VectorXd::Zero(program_.variables());
    for (int i = 0; i < free(); ++i) result[variable_[i]] = d[i] * scale_[i];
    Eigen::Index most = 0;
    const double largest = result.cwiseAbs().maxCoeff(&most);
    variable = static_cast<int>(most);
    curvature /= largest * largest;
    return result / largest;
  }

 private:
  int size() const { return pattern_.rows(); }

  // Applies the inverse of the shifted matrix on the tangent space to d and normalises it.
  void iterate(VectorXd& d) {
    d.tail(size() - free()).setZero();
    ldl_->solve(d.data());
    d /= d.head(free()).norm();
  }

  bool collect(const Evaluation& at) {
    const SparsityPattern& of_jacobian = program_.jacobian_pattern();
    const SparsityPattern& of_hessian = program_.hessian_pattern();
    std::vector<int> unknown(program_.variables(), -1), row(program_.rows(), -1);
    for (int i = 0; i < program_.variables(); ++i)
      if (at.of_variable[i].weight() < infinity) {
        unknown[i] = free();
        variable_.push_back(i);
      }
    std::vector<char> moves(program_.rows(), 0);
    of_jacobian.for_each([&](int r, int c, int e) {
      if (unknown[c] >= 0 && at.jacobian[e] != 0.0) moves[r] = 1;
    });
    int count = free();
    for (int r = 0; r < program_.rows(); ++r)
      if (moves[r] && at.of_row[r].weight() > 0.0) row[r] = count++;

    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i < count; ++i) pairs.emplace_back(i, i);
    const auto place = [&](int r, int c) {
      return std::pair(std::max(unknown[r], unknown[c]), std::min(unknown[r], unknown[c]));
    };
    if (at.has_hessian)
      of_hessian.for_each([&](int r, int c, int) {
        if (unknown[r] >= 0 && unknown[c] >= 0) pairs.push_back(place(r, c));
      });
    of_jacobian.for_each([&](int r, int c, int) {
      if (row[r] >= 0 && unknown[c] >= 0) pairs.emplace_back(row[r], unknown[c]);
    });
    pattern_ = SparsityPattern::from_pairs(count, count, std::move(pairs));
    entries_.assign(pattern_.entries(), 0.0);
    if (at.has_hessian)
      of_hessian.for_each([&](int r, int c, int e) {
        if (unknown[r] < 0 || unknown[c] < 0) return;
        const auto [i, j] = place(r, c);
        entries_[pattern_.find(i, j)] += at.hessian[e];
      });
    of_jacobian.for_each([&](int r, int c, int e) {
      if (row[r] >= 0 && unknown[c] >= 0)
        entries_[pattern_.find(row[r], unknown[c])] = at.jacobian[e];
    });
    equilibrate();
    pattern_.for_each([&](int i, int, int e) {
      if (i < free()) largest_curvature_ = std::max(largest_curvature_, std::abs(entries_[e]));
    });
    const auto square = [](double x) { return x * x; };
    for (int i = 0; i < free(); ++i)
      entries_[pattern_.find(i, i)] +=
          std::min(holds, at.of_variable[variable_[i]].weight() * square(scale_[i]));
    for (int r = 0; r < program_.rows(); ++r)
      if (row[r] >= 0 && at.of_row[r].weight() < infinity)
        entries_[pattern_.find(row[r], row[r])] =
            -std::clamp(square(scale_[row[r]]) / at.of_row[r].weight(), 1.0 / holds, holds);
    for (const double e : entries_)
      if (!std::isfinite(e)) return false;
    std::vector<signed char> signs(count, -1);
    std::fill(signs.begin(), signs.begin() + free(), static_cast<signed char>(1));
    ldl_.emplace(pattern_, std::move(signs));
    for (int e = 0; e < pattern_.entries(); ++e) ldl_->set(e, entries_[e]);
    return true;
  }

  // Scales rows and columns alike until their largest entries are about 1 (Ruiz).
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
  std::vector<int> variable_;  // variable of the program of each unknown
  SparsityPattern pattern_;    // lower triangle
  std::vector<double> entries_;
  VectorXd scale_;
  double largest_curvature_ = 0.0;
  std::optional<qp::SparseLdl> ldl_;
};

// The smallest shift that makes the matrix positive definite, to within 10 %; empty if above 100.
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

// Distance that the point may move along the direction or its negative to the nearest side. At most
// the size of the variable with the largest entry, or 1 if that is smaller.
double room_along(const NonlinearProgram& p, const NlpPoint& point, const Evaluation& at,
                  const VectorXd& direction, int variable) {
  const double most = std::max(1.0, std::abs(point.w[variable]));
  double forwards = most, backwards = most;
  const auto limit = [&](double slope, double value, double lower, double upper) {
    if (lower == upper || slope == 0.0) return;
    const double up = std::max(upper - value, 0.0) / std::abs(slope);
    const double down = std::max(value - lower, 0.0) / std::abs(slope);
    forwards = std::min(forwards, slope > 0.0 ? up : down);
    backwards = std::min(backwards, slope > 0.0 ? down : up);
  };
  for (int i = 0; i < p.variables(); ++i)
    limit(direction[i], point.w[i], p.lower()[i], p.upper()[i]);
  VectorXd slopes = VectorXd::Zero(p.rows());
  p.jacobian_pattern().for_each(
      [&](int r, int c, int e) { slopes[r] += at.jacobian[e] * direction[c]; });
  for (int r = 0; r < p.rows(); ++r)
    limit(slopes[r], at.rows[r], p.row_lower()[r], p.row_upper()[r]);
  return std::max(forwards, backwards);
}

// True if the direction leaves every equality row unchanged: the sum of its terms is small relative
// to the terms, or to the change of the row by a step of this size. The test is independent of
// units.
bool is_along_rows(const NonlinearProgram& p, const Evaluation& at, const VectorXd& sizes,
                   const VectorXd& direction) {
  const double step = direction.cwiseQuotient(sizes).cwiseAbs().maxCoeff();
  VectorXd sum = VectorXd::Zero(p.rows()), terms = sum;
  p.jacobian_pattern().for_each([&](int r, int c, int e) {
    const double term = at.jacobian[e] * direction[c];
    sum[r] += term;
    terms[r] =
        std::max({terms[r], std::abs(term), noise * step * std::abs(at.jacobian[e]) * sizes[c]});
  });
  for (int r = 0; r < p.rows(); ++r)
    if (at.of_row[r].is_equality && std::abs(sum[r]) > off_surface * terms[r]) return false;
  return true;
}

double largest_violation(NonlinearProgram& p, const VectorXd& w, VectorXd& rows) {
  if (!p.constraints(w.data(), rows.data()) || !rows.allFinite()) return infinity;
  double worst = 0.0;
  for (int r = 0; r < p.rows(); ++r)
    worst = std::max({worst, p.row_lower()[r] - rows[r], rows[r] - p.row_upper()[r]});
  return worst;
}

// For vanishing second derivatives: the largest decrease of the cost by steps along the direction
// that satisfy the constraints.
double decrease_along(NonlinearProgram& p, const NlpPoint& point, const Evaluation& at,
                      const VectorXd& direction, double room) {
  VectorXd rows(p.rows());
  const double allowed = off_rows + largest_violation(p, point.w, rows);
  double fall = 0.0;
  for (const double part : {1.0, 0.3, 0.1})
    for (const double sign : {1.0, -1.0}) {
      const VectorXd w =
          (point.w + sign * part * room * direction).cwiseMax(p.lower()).cwiseMin(p.upper());
      double cost = 0.0;
      if (p.objective(w.data(), cost) && std::isfinite(cost) && at.cost - cost > fall &&
          largest_violation(p, w, rows) <= allowed)
        fall = at.cost - cost;
    }
  return fall;
}

// True if the cost itself has second derivatives. Those of the rows alone may consist of errors of
// the multipliers.
bool is_cost_curved(NonlinearProgram& p, const VectorXd& w) {
  const VectorXd none = VectorXd::Zero(p.rows());
  VectorXd hessian(p.hessian_pattern().entries());
  return p.hessian(w.data(), 1.0, none.data(), hessian.data(), Curvature::exact) &&
         hessian.allFinite() && (hessian.array() != 0.0).any();
}

// The predicted decrease of the cost, computed from a multiple of the cost, if the entries of H are
// so small that the shift hides them. Otherwise 0.
double gain_of_small_cost(NonlinearProgram& program, const NlpPoint& point, Evaluation at,
                          double largest_curvature) {
  if (!at.has_hessian || !(largest_curvature > 0.0 && largest_curvature < small) ||
      !is_cost_curved(program, point.w))
    return 0.0;
  const double factor = 1.0 / largest_curvature;
  at.hessian *= factor;
  at.residual *= factor;
  for (auto* sides : {&at.of_variable, &at.of_row})
    for (Side& side : *sides) side.multiplier *= factor;
  KktMatrix matrix(program, at);
  return matrix.is_valid() && matrix.is_positive(flat) ? matrix.gain(at.residual) / factor : 0.0;
}

}  // namespace

OptimumCheck check_optimum(NonlinearProgram& program, const NlpPoint& point,
                           const Quantities& quantities) {
  OptimumCheck result;
  Evaluation at;
  if (!evaluate(program, point, at)) return result;
  const VectorXd sizes = sizes_of(program, point.w, at.jacobian, quantities);
  result.magnitude =
      std::max(std::abs(at.cost), std::min(least_magnitude, change_of_cost(program, at, sizes)));
  if (!(result.magnitude > 0.0)) result.magnitude = least_magnitude;
  result.gap = 0.0;
  for (const auto* sides : {&at.of_variable, &at.of_row})
    for (const Side& side : *sides)
      if (side.multiplier > 0.0 && !side.is_wrong) result.gap += side.multiplier * side.distance;

  KktMatrix matrix(program, at);
  if (!matrix.is_valid()) return result;
  if (matrix.free() == 0) {
    result.curvature = Verdict::minimum;
    return result;
  }
  if (matrix.is_positive(flat)) {
    result.gain = std::max(matrix.gain(at.residual),
                           gain_of_small_cost(program, point, at, matrix.largest_curvature()));
    if (!at.has_hessian) return result;
    result.curvature = Verdict::minimum;
    if (matrix.is_positive(-flat)) return result;
    result.gain = std::max(result.gain, gain_of_one_variable(point, at, sizes));
    if (program.is_linear_quadratic()) return result;
    result.curvature = Verdict::inconclusive;
    if (!matrix.is_positive(flat)) return result;
    const VectorXd d = matrix.least_curvature_direction();
    if (!d.allFinite()) return result;
    double none = 0.0;
    result.direction = matrix.in_program(d, result.variable, none);
    result.descent =
        decrease_along(program, point, at, result.direction,
                       room_along(program, point, at, result.direction, result.variable));
    if (result.descent > 0.0) result.curvature = Verdict::descent;
    return result;
  }
  if (!at.has_hessian) return result;
  const std::optional<double> shift = least_shift(matrix);
  if (!shift || !matrix.is_positive(*shift)) return result;
  result.gain = matrix.gain(at.residual);
  const VectorXd d = matrix.least_curvature_direction();
  auto [curvature, off] = matrix.judge(d);
  if (!d.allFinite() || off > off_surface || !(curvature < -flat)) return result;
  result.direction = matrix.in_program(d, result.variable, curvature);
  if (!is_along_rows(program, at, sizes, result.direction)) return result;
  result.curvature = Verdict::descent;
  const double room = room_along(program, point, at, result.direction, result.variable);
  result.descent = -0.5 * curvature * room * room;
  return result;
}

}  // namespace saltus
