#include "saltus/solver/scaled_program.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

// Derivatives within this range need no scale: solvers have margins of their own, and a program
// that is well stated is solved as it is stated.
constexpr double smallest_usual = 1e-2, largest_usual = 5e3;
constexpr double largest_exponent = 60.0;  // of two

double scale_for(double size) {
  if (!std::isfinite(size) || size <= 0.0 || (size >= smallest_usual && size <= largest_usual))
    return 1.0;
  return std::exp2(std::clamp(-std::round(std::log2(size)), -largest_exponent, largest_exponent));
}

double largest(const std::vector<double>& v) {
  double most = 0.0;
  for (const double x : v) most = std::max(most, std::abs(x));
  return most;
}

// Rows whose slack counts one to one.
void keep_soft_rows(const NonlinearProgram& program, VectorXd& rows) {
  try {
    for (const auto& soft : program.stages().soft_rows) rows[soft.row] = 1.0;
  } catch (const DefinitionError&) {  // it has no stages, and nobody eliminates anything
  }
}

}  // namespace

ProgramScale measure_scale(NonlinearProgram& program, const VectorXd& w) {
  ProgramScale scale{1.0, VectorXd::Ones(program.rows())};
  std::vector<double> gradient(program.variables()), jacobian(program.jacobian_pattern().entries()),
      hessian(program.hessian_pattern().entries());
  const VectorXd no_rows = VectorXd::Zero(program.rows());
  if (w.size() != program.variables() || !program.gradient(w.data(), gradient.data()) ||
      !program.jacobian(w.data(), jacobian.data()))
    return scale;
  double size = largest(gradient);
  const Curvature curvature =
      program.supports(Curvature::exact) ? Curvature::exact : Curvature::gauss_newton;
  if (program.supports(curvature) &&
      program.hessian(w.data(), 1.0, no_rows.data(), hessian.data(), curvature))
    size = std::max(size, largest(hessian));
  scale.cost = scale_for(size);
  VectorXd row_size = VectorXd::Zero(program.rows());
  program.jacobian_pattern().for_each(
      [&](int r, int, int e) { row_size[r] = std::max(row_size[r], std::abs(jacobian[e])); });
  for (int r = 0; r < program.rows(); ++r) scale.rows[r] = scale_for(row_size[r]);
  if ((scale.rows.array() != 1.0).any()) keep_soft_rows(program, scale.rows);
  return scale;
}

ScaledProgram::ScaledProgram(NonlinearProgram& program, ProgramScale scale)
    : program_(program),
      scale_(std::move(scale)),
      row_lower_(program.row_lower().cwiseProduct(scale_.rows)),
      row_upper_(program.row_upper().cwiseProduct(scale_.rows)),
      lambda_(VectorXd::Zero(program.rows())) {}

// cost' = c cost and g' = D g: c grad f + J' D lambda' + z' = 0 with lambda = D lambda' / c.
NlpPoint ScaledProgram::to_scaled(NlpPoint point) const {
  if (point.lambda.size() == rows())
    point.lambda = (scale_.cost * point.lambda.array() / scale_.rows.array()).matrix();
  point.z *= scale_.cost;
  return point;
}

NlpPoint ScaledProgram::from_scaled(NlpPoint point) const {
  if (point.lambda.size() == rows())
    point.lambda = (point.lambda.array() * scale_.rows.array() / scale_.cost).matrix();
  point.z /= scale_.cost;
  return point;
}

bool ScaledProgram::objective(const double* w, double& f) {
  if (!program_.objective(w, f)) return false;
  f *= scale_.cost;
  return true;
}

bool ScaledProgram::gradient(const double* w, double* gradient) {
  if (!program_.gradient(w, gradient)) return false;
  for (int i = 0; i < variables(); ++i) gradient[i] *= scale_.cost;
  return true;
}

bool ScaledProgram::constraints(const double* w, double* g) {
  if (!program_.constraints(w, g)) return false;
  for (int r = 0; r < rows(); ++r) g[r] *= scale_.rows[r];
  return true;
}

bool ScaledProgram::jacobian(const double* w, double* entries) {
  if (!program_.jacobian(w, entries)) return false;
  jacobian_pattern().for_each([&](int r, int, int e) { entries[e] *= scale_.rows[r]; });
  return true;
}

bool ScaledProgram::hessian(const double* w, double sigma, const double* lambda, double* entries,
                            Curvature curvature) {
  for (int r = 0; r < rows(); ++r) lambda_[r] = lambda[r] * scale_.rows[r];
  return program_.hessian(w, sigma * scale_.cost, lambda_.data(), entries, curvature);
}

NlpResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                         bool warm, KktResidual& scaled) {
  ProgramScale scale = measure_scale(program, start.w);
  if (scale.is_one()) {
    NlpResult result = solver.solve(program, start, warm);
    scaled = result.kkt;
    return result;
  }
  ScaledProgram in_scale(program, std::move(scale));
  NlpResult result = solver.solve(in_scale, in_scale.to_scaled(start), warm);
  scaled = result.kkt;
  result.point = in_scale.from_scaled(std::move(result.point));
  if (!program.objective(result.point.w.data(), result.objective) && is_success(result.status))
    result.status = SolveStatus::evaluation_failed;
  result.kkt = kkt_residual(program, result.point);
  return result;
}

}  // namespace saltus
