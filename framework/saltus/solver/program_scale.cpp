#include "saltus/solver/optimum_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"

namespace saltus {
namespace {

// range of derivatives that need no scaling
constexpr double smallest_usual = 1e-2, largest_usual = 5e3;
constexpr double smallest_value = 1e-2, largest_value = 1e2;
constexpr double smallest_cost = 1e-3;
// Over one interval, states move by a fraction of their size.
constexpr double smallest_estimate = 1e-4, largest_estimate = 1e6;
constexpr double largest_scale = 1e18;
// Values that solvers leave of a zero do not determine a size.
constexpr double least_value = 1e-9;
constexpr double largest_bound = 1e8;  // larger bounds are placeholders

bool is_well_scaled_size(double size) { return size >= smallest_usual && size <= largest_usual; }

double inverse(double size) {
  if (!std::isfinite(size) || size <= 0.0) return 1.0;
  return std::clamp(1.0 / size, 1.0 / largest_scale, largest_scale);
}

// 1 for a well-scaled size, otherwise the power of two that brings it close to 1.
double power_of_two(double size) {
  return is_well_scaled_size(size) ? 1.0 : std::exp2(std::round(std::log2(inverse(size))));
}

// Slacks that stage solvers eliminate enter their rows with coefficient one.
std::vector<qp::StageStructure::SoftRow> soft_rows(const NonlinearProgram& program) {
  try {
    return program.stages().soft_rows;
  } catch (const DefinitionError&) {  // no stages: nothing is eliminated
    return {};
  }
}

}  // namespace

bool ProgramScale::is_one() const {
  return cost == 1.0 && (rows.array() == 1.0).all() && (variables.array() == 1.0).all();
}

VectorXd estimate_sizes_from_rows(const NonlinearProgram& program, const VectorXd& jacobian,
                                  const std::vector<int>& quantity_of, VectorXd size) {
  const SparsityPattern& pattern = program.jacobian_pattern();
  for (bool goes_on = (size.array() == 0.0).any(); goes_on;) {
    VectorXd row = VectorXd::Zero(program.rows());
    pattern.for_each([&](int r, int c, int e) {
      const int q = quantity_of[c];
      row[r] = std::max(row[r], std::abs(jacobian[e]) * (q < 0 ? 1.0 : size[q]));
    });
    VectorXd found = VectorXd::Constant(size.size(), infinity);
    pattern.for_each([&](int r, int c, int e) {
      const int q = quantity_of[c];
      if (q >= 0 && size[q] == 0.0 && jacobian[e] != 0.0 && row[r] > 0.0)
        found[q] = std::min(found[q], row[r] / std::abs(jacobian[e]));
    });
    // continue with quantities that depend on those just found
    goes_on = (found.array() < infinity).any();
    size = (found.array() < infinity).select(found, size);
  }
  return size;
}

ProgramSize::ProgramSize(NonlinearProgram& program, Quantities quantities)
    : program_(program),
      quantities_(std::move(quantities)),
      quantity_of_(program.variables(), -1),
      values_(VectorXd::Zero(quantities_.size())),
      gradient_(VectorXd::Zero(program.variables())),
      jacobian_(VectorXd::Zero(program.jacobian_pattern().entries())),
      hessian_(VectorXd::Zero(program.hessian_pattern().entries())) {
  for (int q = 0; q < values_.size(); ++q)
    for (const int v : quantities_[q]) quantity_of_[v] = q;
}

bool ProgramSize::look_at(const VectorXd& w) {
  const int n = program_.variables();
  VectorXd gradient(n), jacobian(jacobian_.size());
  if (w.size() != n || !w.allFinite() || !program_.gradient(w.data(), gradient.data()) ||
      !program_.jacobian(w.data(), jacobian.data()) || !gradient.allFinite() ||
      !jacobian.allFinite())
    return false;
  if (!std::exchange(has_hessian_, true)) look_at_curvature(w);
  gradient.tail(n - program_.first_slack()).setZero();  // a penalty weight is not a size
  gradient_ = gradient_.cwiseMax(gradient.cwiseAbs());
  jacobian_ = jacobian_.cwiseMax(jacobian.cwiseAbs());
  for (int v = 0; v < n; ++v)
    if (quantity_of_[v] >= 0)
      values_[quantity_of_[v]] = std::max(values_[quantity_of_[v]], std::abs(w[v]));
  return true;
}

void ProgramSize::look_at_curvature(const VectorXd& w) {
  const VectorXd no_rows = VectorXd::Zero(program_.rows());
  VectorXd hessian(hessian_.size());
  const Curvature curvature =
      program_.supports(Curvature::exact) ? Curvature::exact : Curvature::gauss_newton;
  if (program_.supports(curvature) &&
      program_.hessian(w.data(), 1.0, no_rows.data(), hessian.data(), curvature) &&
      hessian.allFinite()) {
    hessian_ = hessian.cwiseAbs();
    program_.hessian_pattern().for_each([&](int i, int, int e) {
      if (i >= program_.first_slack()) hessian_[e] = 0.0;
    });
  }
}

VectorXd ProgramSize::known_sizes() const {
  return (values_.array() >= least_value).select(values_, 0.0);
}

VectorXd ProgramSize::sizes() const {
  VectorXd size = estimate_sizes_from_rows(program_, jacobian_, quantity_of_, known_sizes());
  if ((size.array() > 0.0).all()) return size;
  return estimate_sizes_from_rows(program_, jacobian_, quantity_of_, sizes_with_bounds(size));
}

// Sizes of 0 become those that the bounds allow: of the variables, and of the rows in which they
// appear.
VectorXd ProgramSize::sizes_with_bounds(VectorXd size) const {
  VectorXd found = VectorXd::Constant(size.size(), infinity);
  const auto look = [&](int v, double lower, double upper, double slope) {
    const int q = quantity_of_[v];
    if (q < 0 || size[q] > 0.0) return;
    double bound = 0.0;
    for (const double side : {std::abs(lower), std::abs(upper)})
      if (side <= largest_bound) bound = std::max(bound, side);
    if (bound > 0.0 && slope > 0.0) found[q] = std::min(found[q], bound / slope);
  };
  for (int v = 0; v < program_.variables(); ++v)
    look(v, program_.lower()[v], program_.upper()[v], 1.0);
  program_.jacobian_pattern().for_each([&](int r, int c, int e) {
    look(c, program_.row_lower()[r], program_.row_upper()[r], std::abs(jacobian_[e]));
  });
  return (found.array() < infinity).select(found, size);
}

bool ProgramSize::is_well_scaled_where_known(const ProgramScale& scale) const {
  const VectorXd size = known_sizes();
  for (int q = 0; q < size.size(); ++q) {
    const double unit = scale.variables.size() > 0 ? scale.variables[quantities_[q].front()] : 1.0;
    if (size[q] > 0.0 && (size[q] * unit < smallest_value || size[q] * unit > largest_value))
      return false;
  }
  return scale.cost >= smallest_cost * to_one().cost;
}

bool ProgramSize::is_badly_scaled(const ProgramScale& scale) const {
  const ProgramScale one = to_one();
  const auto is_far = [](double size) {
    return size < smallest_estimate || size > largest_estimate;
  };
  if (is_far(scale.cost / one.cost)) return true;
  for (int r = 0; r < one.rows.size(); ++r)
    if (is_far(scale.rows[r] / one.rows[r])) return true;
  for (int v = 0; v < one.variables.size(); ++v)
    if (is_far((scale.variables.size() > 0 ? scale.variables[v] : 1.0) / one.variables[v]))
      return true;
  return false;
}

ProgramScale ProgramSize::usual() const {
  ProgramScale scale{1.0, VectorXd::Zero(program_.rows())};
  double cost = 0.0;
  for (const VectorXd* entries : {&gradient_, &hessian_})
    if (entries->size() > 0) cost = std::max(cost, entries->maxCoeff());
  scale.cost = power_of_two(cost);
  program_.jacobian_pattern().for_each(
      [&](int r, int, int e) { scale.rows[r] = std::max(scale.rows[r], jacobian_[e]); });
  for (double& row : scale.rows) row = power_of_two(row);
  if ((scale.rows.array() != 1.0).any())
    for (const auto& soft : soft_rows(program_)) scale.rows[soft.row] = 1.0;
  return scale;
}

ProgramScale ProgramSize::to_one() const {
  ProgramScale scale{1.0, VectorXd::Zero(program_.rows()), VectorXd::Ones(program_.variables())};
  VectorXd& unit = scale.variables;
  const VectorXd size = sizes();
  for (int v = 0; v < unit.size(); ++v)
    if (quantity_of_[v] >= 0) unit[v] = inverse(size[quantity_of_[v]]);

  const std::vector<qp::StageStructure::SoftRow> soft = soft_rows(program_);
  std::vector<char> is_slack(unit.size(), 0);
  for (const auto& s : soft)
    for (const int slack : {s.below, s.above})
      if (slack >= 0) is_slack[slack] = 1;
  program_.jacobian_pattern().for_each([&](int r, int c, int e) {
    if (!is_slack[c]) scale.rows[r] = std::max(scale.rows[r], jacobian_[e] / unit[c]);
  });
  for (double& row : scale.rows) row = inverse(row);
  for (const auto& s : soft)
    for (const int slack : {s.below, s.above})
      if (slack >= 0) unit[slack] = scale.rows[s.row];

  double cost = 0.0;
  for (int v = 0; v < unit.size(); ++v) cost = std::max(cost, gradient_[v] / unit[v]);
  program_.hessian_pattern().for_each(
      [&](int i, int j, int e) { cost = std::max(cost, hessian_[e] / (unit[i] * unit[j])); });
  scale.cost = inverse(cost);
  return scale;
}

}  // namespace saltus
