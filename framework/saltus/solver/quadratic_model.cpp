#include "saltus/solver/quadratic_model.hpp"

#include "saltus/solver/convexify.hpp"

namespace saltus {

void multiply_symmetric(const SparsityPattern& pattern, const VectorXd& entries, const VectorXd& v,
                        VectorXd& out) {
  out.setZero();
  pattern.for_each([&](int r, int c, int e) {
    out[r] += entries[e] * v[c];
    if (r != c) out[c] += entries[e] * v[r];
  });
}

void multiply(const SparsityPattern& pattern, const VectorXd& entries, const VectorXd& v,
              VectorXd& out) {
  out.setZero();
  pattern.for_each([&](int r, int c, int e) { out[r] += entries[e] * v[c]; });
}

QuadraticModel::QuadraticModel(const NonlinearProgram& program)
    : qp_(program.is_linear_quadratic() ? program.hessian_pattern()
                                        : with_diagonal(program.hessian_pattern()),
          program.jacobian_pattern()),
      hessian_(program.hessian_pattern().entries()),
      w0_(VectorXd::Zero(program.variables())),
      gradient_(VectorXd::Zero(program.variables())),
      c_(VectorXd::Zero(program.rows())),
      offset_(VectorXd::Zero(program.rows())) {
  if (qp_.hessian_pattern == program.hessian_pattern()) return;
  program.hessian_pattern().for_each(
      [&](int r, int c, int) { position_.push_back(qp_.hessian_pattern.find(r, c)); });
}

bool QuadraticModel::linearise(NonlinearProgram& program, const VectorXd& w, const VectorXd& lambda,
                               Curvature curvature) {
  program.prepare_derivatives(w.data(), 1.0, lambda.data(), curvature);
  // Derivatives come first: a program that caches its evaluations then has the values as well.
  if (!program.gradient(w.data(), gradient_.data()) ||
      !program.jacobian(w.data(), qp_.rows.data()) || !evaluate(program, w))
    return false;
  multiply(qp_.row_pattern, qp_.rows, w0_, offset_);
  offset_ = c_ - offset_;
  update_bounds(program);
  return set_curvature(program, lambda, curvature);
}

bool QuadraticModel::linearise(NonlinearProgram& program, const VectorXd& w, const VectorXd& lambda,
                               Curvature curvature, const VectorXd& rows_times_w) {
  program.prepare_derivatives(w.data(), 1.0, lambda.data(), curvature);
  if (!program.gradient(w.data(), gradient_.data()) || !evaluate(program, w)) return false;
  offset_ = c_ - rows_times_w;
  update_bounds(program);
  return set_curvature(program, lambda, curvature);
}

bool QuadraticModel::evaluate(NonlinearProgram& program, const VectorXd& w) {
  w0_ = w;
  return program.constraints(w0_.data(), c_.data()) && program.objective(w0_.data(), cost_);
}

bool QuadraticModel::set_curvature(NonlinearProgram& program, const VectorXd& lambda,
                                   Curvature curvature) {
  const bool same = position_.empty();
  const bool ok = program.hessian(w0_.data(), 1.0, lambda.data(),
                                  same ? qp_.hessian.data() : hessian_.data(), curvature);
  if (!same) {
    qp_.hessian.setZero();
    for (std::size_t e = 0; e < position_.size(); ++e) qp_.hessian[position_[e]] = hessian_[e];
  }
  hessian_changed();
  return ok;
}

void QuadraticModel::hessian_changed() {
  if (w0_.isZero(0.0)) {
    qp_.gradient = gradient_;
    qp_.constant = cost_;
    return;
  }
  multiply_symmetric(qp_.hessian_pattern, qp_.hessian, w0_, qp_.gradient);
  const double bent = w0_.dot(qp_.gradient);
  qp_.gradient = gradient_ - qp_.gradient;
  qp_.constant = cost_ - gradient_.dot(w0_) + 0.5 * bent;
}

void QuadraticModel::update_bounds(const NonlinearProgram& program) {
  qp_.lower = program.lower();
  qp_.upper = program.upper();
  shift_rows(program);
}

void QuadraticModel::shift_rows(const NonlinearProgram& program) {
  qp_.row_lower = program.row_lower() - offset_;
  qp_.row_upper = program.row_upper() - offset_;
}

void QuadraticModel::correct_rows(const NonlinearProgram& program, const VectorXd& w,
                                  const VectorXd& c) {
  multiply(qp_.row_pattern, qp_.rows, w, offset_);
  offset_ = c - offset_;
  shift_rows(program);
}

}  // namespace saltus
