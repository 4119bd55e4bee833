#include "saltus/solver/scaled_program.hpp"

#include <utility>

#include "saltus/core/bounds.hpp"

namespace saltus {
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

int ScaledProgram::leave_out_idle_sides() {
  if (scale_.variables.size() == 0) return 0;
  constexpr double idle = 1e6;
  int count = 0;
  const auto look_at = [&](double& lower, double& upper) {
    if (lower > 0.0 || upper < 0.0) return;  // the range does not contain zero
    if (lower <= -idle && lower > -infinity) lower = -infinity, ++count;
    if (upper >= idle && upper < infinity) upper = infinity, ++count;
  };
  for (int i = 0; i < variables(); ++i) look_at(lower_[i], upper_[i]);
  for (int r = 0; r < rows(); ++r) look_at(row_lower_[r], row_upper_[r]);
  return count;
}

const double* ScaledProgram::unscaled(const double* w) {
  if (scale_.variables.size() == 0) return w;
  for (int i = 0; i < variables(); ++i) w_[i] = w[i] / scale_.variables[i];
  return w_.data();
}

// For cost' = c cost, g' = D g and w' = S w: c S^-1 grad f + S^-1 J' D lambda' + z' = 0 with lambda
// = D lambda' / c and z = S z' / c.
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

void ScaledProgram::prepare_derivatives(const double* w, double sigma, const double* lambda,
                                        Curvature curvature) {
  for (int r = 0; r < rows(); ++r) lambda_[r] = lambda[r] * scale_.rows[r];
  program_.prepare_derivatives(unscaled(w), sigma * scale_.cost, lambda_.data(), curvature);
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

}  // namespace saltus
