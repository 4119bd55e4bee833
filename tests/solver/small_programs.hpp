// Small programs for the solvers alone, without phases and integrators.
#pragma once

#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "saltus/core/bounds.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus::testing_support {

/// Two variables and some rows that depend on both. Members are public; there are no bounds by
/// default.
class OfTwoVariables : public NonlinearProgram {
 public:
  explicit OfTwoVariables(int rows)
      : row_lower_(VectorXd::Constant(rows, -infinity)),
        row_upper_(VectorXd::Constant(rows, infinity)),
        jacobian_(SparsityPattern::dense(rows, 2)) {}
  VectorXd lower_ = VectorXd::Constant(2, -infinity), upper_ = VectorXd::Constant(2, infinity);
  VectorXd row_lower_, row_upper_;

  int variables() const override { return 2; }
  int rows() const override { return static_cast<int>(row_lower_.size()); }
  const VectorXd& lower() const override { return lower_; }
  const VectorXd& upper() const override { return upper_; }
  const VectorXd& row_lower() const override { return row_lower_; }
  const VectorXd& row_upper() const override { return row_upper_; }
  const SparsityPattern& jacobian_pattern() const override { return jacobian_; }
  const SparsityPattern& hessian_pattern() const override { return hessian_; }
  bool supports(Curvature) const override { return true; }
  std::string describe_variable(int i) const override { return "variable " + std::to_string(i); }
  std::string describe_row(int i) const override { return "row " + std::to_string(i); }

 private:
  SparsityPattern jacobian_;
  SparsityPattern hessian_ = SparsityPattern::from_pairs(2, 2, {{0, 0}, {1, 0}, {1, 1}});
};

/// min (a - 1)^2 + 100 (b - a^2)^2 with one row: row_lower <= a + b <= row_upper. Members that
/// tests change are public.
class Rosenbrock : public OfTwoVariables {
 public:
  Rosenbrock() : OfTwoVariables(1) {}
  double seconds_per_evaluation = 0.0;
  bool fails = false;
  bool has_curvature = true;

  bool supports(Curvature) const override { return has_curvature; }

  bool objective(const double* w, double& f) override {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds_per_evaluation));
    const double valley = w[1] - w[0] * w[0];
    f = (w[0] - 1.0) * (w[0] - 1.0) + 100.0 * valley * valley;
    return !fails;
  }
  bool gradient(const double* w, double* g) override {
    const double valley = w[1] - w[0] * w[0];
    g[0] = 2.0 * (w[0] - 1.0) - 400.0 * valley * w[0];
    g[1] = 200.0 * valley;
    return !fails;
  }
  bool constraints(const double* w, double* g) override {
    g[0] = w[0] + w[1];
    return !fails;
  }
  bool jacobian(const double*, double* entries) override {
    entries[0] = entries[1] = 1.0;
    return !fails;
  }
  bool hessian(const double* w, double sigma, const double*, double* entries, Curvature) override {
    entries[0] = sigma * (2.0 - 400.0 * (w[1] - 3.0 * w[0] * w[0]));
    entries[1] = -sigma * 400.0 * w[0];
    entries[2] = sigma * 200.0;
    return !fails;
  }
};

}  // namespace saltus::testing_support
