// Where steps towards the optimum fail: the nearest point at which the rows are met.
//
//     min weight sum(p + q) + zeta/2 |D (w - w0)|^2
//     subject to   lower <= w <= upper,  row_lower <= g(w) - p + q <= row_upper,  p, q >= 0,
//
// D = 1 / max(1, |w0|). At a solution with p + q > 0 the rows cannot be met near w0.
// Waechter and Biegler, Math. Program. 106, 2006, sec. 3.3.
#pragma once

#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

class RestorationProgram final : public NonlinearProgram {
 public:
  /// `program` must outlive this one; its data may change. Its variables come first, then p, q.
  explicit RestorationProgram(NonlinearProgram& program);

  /// Of the program as it is now, from w0.
  void restart(const VectorXd& w0, double zeta);
  static constexpr double weight = 1000.0;

  int variables() const override { return n_ + 2 * m_; }
  int rows() const override { return m_; }
  const VectorXd& lower() const override { return lower_; }
  const VectorXd& upper() const override { return upper_; }
  const VectorXd& row_lower() const override { return program_.row_lower(); }
  const VectorXd& row_upper() const override { return program_.row_upper(); }
  const SparsityPattern& jacobian_pattern() const override { return jacobian_pattern_; }
  const SparsityPattern& hessian_pattern() const override { return hessian_pattern_; }
  bool supports(Curvature curvature) const override { return program_.supports(curvature); }

  bool objective(const double* w, double& f) override;
  bool gradient(const double* w, double* gradient) override;
  bool constraints(const double* w, double* g) override;
  bool jacobian(const double* w, double* entries) override;
  bool hessian(const double* w, double sigma, const double* lambda, double* entries,
               Curvature curvature) override;

  std::string describe_variable(int i) const override;
  std::string describe_row(int i) const override { return program_.describe_row(i); }

 private:
  NonlinearProgram& program_;
  int n_, m_;
  SparsityPattern jacobian_pattern_, hessian_pattern_;
  std::vector<int> jacobian_position_, hessian_position_, diagonal_position_;
  std::vector<double> jacobian_entries_, hessian_entries_;
  VectorXd lower_, upper_, w0_, d_;
  double zeta_ = 0.0;
};

}  // namespace saltus
