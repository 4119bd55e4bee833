#include "problems/library/quadratic_program.hpp"

namespace saltus::library {

bool QuadraticProgram::objective(const double* w, double& f) {
  f = qp::objective(qp_, Eigen::Map<const VectorXd>(w, variables()));
  return true;
}

bool QuadraticProgram::gradient(const double* w, double* gradient) {
  Eigen::Map<VectorXd> sum(gradient, variables());
  sum = qp_.gradient;
  qp_.hessian_pattern.for_each([&](int i, int j, int e) {
    sum[i] += qp_.hessian[e] * w[j];
    if (i != j) sum[j] += qp_.hessian[e] * w[i];
  });
  return true;
}

bool QuadraticProgram::constraints(const double* w, double* g) {
  Eigen::Map<VectorXd> sum(g, rows());
  sum.setZero();
  qp_.row_pattern.for_each([&](int i, int j, int e) { sum[i] += qp_.rows[e] * w[j]; });
  return true;
}

bool QuadraticProgram::jacobian(const double*, double* entries) {
  Eigen::Map<VectorXd>(entries, qp_.rows.size()) = qp_.rows;
  return true;
}

bool QuadraticProgram::hessian(const double*, double sigma, const double*, double* entries,
                               Curvature) {
  Eigen::Map<VectorXd>(entries, qp_.hessian.size()) = sigma * qp_.hessian;
  return true;
}

}  // namespace saltus::library
