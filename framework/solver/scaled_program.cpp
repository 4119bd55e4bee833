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

double scale_for(double size) {
  if (!std::isfinite(size) || size <= 0.0 || (size >= smallest_usual && size <= largest_usual))
    return 1.0;
  return std::exp2(std::clamp(-std::round(std::log2(size)), -largest_exponent, largest_exponent));
}

ProgramScale measure_scale(NonlinearProgram& program, const VectorXd& w, VectorXd variables) {
  ProgramScale scale{1.0, VectorXd::Ones(program.rows()), std::move(variables)};
  const auto unit = [&](int i) { return scale.variables.size() > 0 ? scale.variables[i] : 1.0; };
  std::vector<double> gradient(program.variables()), jacobian(program.jacobian_pattern().entries()),
      hessian(program.hessian_pattern().entries());
  const VectorXd no_rows = VectorXd::Zero(program.rows());
  if (w.size() != program.variables() || !program.gradient(w.data(), gradient.data()) ||
      !program.jacobian(w.data(), jacobian.data()))
    return scale;
  for (int i = 0; i < program.variables(); ++i) gradient[i] /= unit(i);
  double size = largest(gradient);
  const Curvature curvature =
      program.supports(Curvature::exact) ? Curvature::exact : Curvature::gauss_newton;
  if (program.supports(curvature) &&
      program.hessian(w.data(), 1.0, no_rows.data(), hessian.data(), curvature)) {
    program.hessian_pattern().for_each(
        [&](int i, int j, int e) { hessian[e] /= unit(i) * unit(j); });
    size = std::max(size, largest(hessian));
  }
  scale.cost = scale_for(size);
  VectorXd row_size = VectorXd::Zero(program.rows());
  program.jacobian_pattern().for_each([&](int r, int c, int e) {
    row_size[r] = std::max(row_size[r], std::abs(jacobian[e]) / unit(c));
  });
  for (int r = 0; r < program.rows(); ++r) scale.rows[r] = scale_for(row_size[r]);
  if ((scale.rows.array() != 1.0).any()) keep_soft_rows(program, scale.rows);
  return scale;
}

ScaledProgram::ScaledProgram(NonlinearProgram& program, ProgramScale scale)
    : program_(program),
      scale_(std::move(scale)),
      lower_(program.lower()),
      upper_(program.upper()),
      row_lower_(program.row_lower().cwiseProduct(scale_.rows)),
      row_upper_(program.row_upper().cwiseProduct(scale_.rows)),
      lambda_(VectorXd::Zero(program.rows())) {
  if ((scale_.variables.array() == 1.0).all()) scale_.variables = {};
  if (scale_.variables.size() == 0) return;
  lower_.array() *= scale_.variables.array();
  upper_.array() *= scale_.variables.array();
  w_ = VectorXd::Zero(program.variables());
}

const double* ScaledProgram::unscaled(const double* w) {
  if (scale_.variables.size() == 0) return w;
  for (int i = 0; i < variables(); ++i) w_[i] = w[i] / scale_.variables[i];
  return w_.data();
}

// cost' = c cost, g' = D g and w' = S w: c S^-1 grad f + S^-1 J' D lambda' + z' = 0 with
// lambda = D lambda' / c and z = S z' / c.
NlpPoint ScaledProgram::to_scaled(NlpPoint point) const {
  if (point.lambda.size() == rows())
    point.lambda = (scale_.cost * point.lambda.array() / scale_.rows.array()).matrix();
  point.z *= scale_.cost;
  if (scale_.variables.size() == 0) return point;
  if (point.w.size() == variables()) point.w.array() *= scale_.variables.array();
  if (point.z.size() == variables()) point.z.array() /= scale_.variables.array();
  return point;
}

NlpPoint ScaledProgram::from_scaled(NlpPoint point) const {
  if (point.lambda.size() == rows())
    point.lambda = (point.lambda.array() * scale_.rows.array() / scale_.cost).matrix();
  point.z /= scale_.cost;
  if (scale_.variables.size() == 0) return point;
  if (point.w.size() == variables()) point.w.array() /= scale_.variables.array();
  if (point.z.size() == variables()) point.z.array() *= scale_.variables.array();
  return point;
}

bool ScaledProgram::objective(const double* w, double& f) {
  if (!program_.objective(unscaled(w), f)) return false;
  f *= scale_.cost;
  return true;
}

bool ScaledProgram::gradient(const double* w, double* gradient) {
  if (!program_.gradient(unscaled(w), gradient)) return false;
  for (int i = 0; i < variables(); ++i) gradient[i] *= scale_.cost;
  for (int i = 0; i < scale_.variables.size(); ++i) gradient[i] /= scale_.variables[i];
  return true;
}

bool ScaledProgram::constraints(const double* w, double* g) {
  if (!program_.constraints(unscaled(w), g)) return false;
  for (int r = 0; r < rows(); ++r) g[r] *= scale_.rows[r];
  return true;
}

bool ScaledProgram::jacobian(const double* w, double* entries) {
  if (!program_.jacobian(unscaled(w), entries)) return false;
  const bool same_variables = scale_.variables.size() == 0;
  jacobian_pattern().for_each([&](int r, int c, int e) {
    entries[e] *= same_variables ? scale_.rows[r] : scale_.rows[r] / scale_.variables[c];
  });
  return true;
}

bool ScaledProgram::hessian(const double* w, double sigma, const double* lambda, double* entries,
                            Curvature curvature) {
  for (int r = 0; r < rows(); ++r) lambda_[r] = lambda[r] * scale_.rows[r];
  if (!program_.hessian(unscaled(w), sigma * scale_.cost, lambda_.data(), entries, curvature))
    return false;
  if (scale_.variables.size() > 0)
    hessian_pattern().for_each(
        [&](int i, int j, int e) { entries[e] /= scale_.variables[i] * scale_.variables[j]; });
  return true;
}

NlpResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                         bool warm, KktResidual& scaled, VectorXd variables) {
  ProgramScale scale = measure_scale(program, start.w, std::move(variables));
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
