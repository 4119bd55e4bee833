// Small programs for the solvers alone, without phases and integrators.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus::testing_support {

/// A program with stored bounds, which tests change, and patterns. There are no bounds by default.
class StoredProgram : public NonlinearProgram {
 public:
  StoredProgram(SparsityPattern jacobian, SparsityPattern hessian)
      : lower_(VectorXd::Constant(jacobian.cols(), -infinity)),
        upper_(VectorXd::Constant(jacobian.cols(), infinity)),
        row_lower_(VectorXd::Constant(jacobian.rows(), -infinity)),
        row_upper_(VectorXd::Constant(jacobian.rows(), infinity)),
        jacobian_(std::move(jacobian)),
        hessian_(std::move(hessian)) {}
  VectorXd lower_, upper_, row_lower_, row_upper_;

  int variables() const override { return jacobian_.cols(); }
  int rows() const override { return jacobian_.rows(); }
  const VectorXd& lower() const override { return lower_; }
  const VectorXd& upper() const override { return upper_; }
  const VectorXd& row_lower() const override { return row_lower_; }
  const VectorXd& row_upper() const override { return row_upper_; }
  const SparsityPattern& jacobian_pattern() const override { return jacobian_; }
  const SparsityPattern& hessian_pattern() const override { return hessian_; }
  bool supports(Curvature) const override { return true; }
  std::string describe_variable(int i) const override { return "variable " + std::to_string(i); }
  std::string describe_row(int i) const override { return "row " + std::to_string(i); }

 protected:
  SparsityPattern jacobian_, hessian_;
};

/// Rows without a cost.
class RowsOnly : public StoredProgram {
 public:
  using StoredProgram::StoredProgram;
  bool objective(const double*, double& f) override {
    f = 0.0;
    return true;
  }
  bool gradient(const double*, double* g) override {
    std::fill_n(g, variables(), 0.0);
    return true;
  }
  bool hessian(const double*, double, const double*, double*, Curvature) override { return true; }
};

/// Two variables and some rows that depend on both.
class OfTwoVariables : public StoredProgram {
 public:
  explicit OfTwoVariables(int rows)
      : StoredProgram(SparsityPattern::dense(rows, 2),
                      SparsityPattern::from_pairs(2, 2, {{0, 0}, {1, 0}, {1, 1}})) {}
};

/// min (w - centre)^2 / 2 within bounds, without rows and stages.
class Parabola final : public StoredProgram {
 public:
  /// `is_quadratic` is the answer of is_linear_quadratic().
  Parabola(double centre, Bounds bounds, bool is_quadratic)
      : StoredProgram(SparsityPattern::from_pairs(0, 1, {}),
                      SparsityPattern::from_pairs(1, 1, {{0, 0}})),
        centre_(centre),
        is_quadratic_(is_quadratic) {
    lower_[0] = bounds.lower;
    upper_[0] = bounds.upper;
  }

  bool is_linear_quadratic() const override { return is_quadratic_; }
  bool objective(const double* w, double& f) override {
    f = 0.5 * (w[0] - centre_) * (w[0] - centre_);
    return true;
  }
  bool gradient(const double* w, double* g) override {
    g[0] = w[0] - centre_;
    return true;
  }
  bool constraints(const double*, double*) override { return true; }
  bool jacobian(const double*, double*) override { return true; }
  bool hessian(const double*, double sigma, const double*, double* h, Curvature) override {
    h[0] = sigma;
    return true;
  }

 private:
  double centre_;
  bool is_quadratic_;
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
