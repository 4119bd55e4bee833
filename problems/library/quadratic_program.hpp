// A quadratic program with sparse data as a NonlinearProgram, for every solver.
#pragma once

#include <string>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus::library {

class QuadraticProgram final : public NonlinearProgram {
 public:
  explicit QuadraticProgram(qp::SparseQp qp) : qp_(std::move(qp)) {}

  int variables() const override { return qp_.variables(); }
  int rows() const override { return qp_.row_pattern.rows(); }
  const VectorXd& lower() const override { return qp_.lower; }
  const VectorXd& upper() const override { return qp_.upper; }
  const VectorXd& row_lower() const override { return qp_.row_lower; }
  const VectorXd& row_upper() const override { return qp_.row_upper; }
  const SparsityPattern& jacobian_pattern() const override { return qp_.row_pattern; }
  const SparsityPattern& hessian_pattern() const override { return qp_.hessian_pattern; }
  bool supports(Curvature) const override { return true; }
  bool is_linear_quadratic() const override { return true; }
  long revision() const override { return 0; }

  bool objective(const double* w, double& f) override;
  bool gradient(const double* w, double* gradient) override;
  bool constraints(const double* w, double* g) override;
  bool jacobian(const double* w, double* entries) override;
  bool hessian(const double* w, double sigma, const double* lambda, double* entries,
               Curvature curvature) override;

  std::string describe_variable(int i) const override { return "variable " + std::to_string(i); }
  std::string describe_row(int i) const override { return "row " + std::to_string(i); }

 private:
  qp::SparseQp qp_;
};

}  // namespace saltus::library
