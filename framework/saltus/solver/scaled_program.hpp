// A badly scaled program in the scaling that solvers see.
#pragma once

#include <string>

#include "saltus/solver/optimum_check.hpp"

namespace saltus {

/// The program times a scale, with the same patterns and stages. The program must outlive it, and
/// its data must not change meanwhile.
class ScaledProgram final : public NonlinearProgram {
 public:
  /// `program` must outlive this object.
  ScaledProgram(NonlinearProgram& program, ProgramScale scale);

  /// Removes sides of magnitude 1e6 and above from ranges that contain zero, if variables are
  /// divided by their sizes. Such sides are rarely active. The result must be checked against them.
  /// Returns the number of removed sides.
  int leave_out_idle_sides();
  /// Converts a point of the given program to the scaled one.
  NlpPoint to_scaled(NlpPoint point) const;
  /// Converts a point of the scaled program to the given one.
  NlpPoint from_scaled(NlpPoint point) const;

  int variables() const override { return program_.variables(); }
  int rows() const override { return program_.rows(); }
  const VectorXd& lower() const override { return lower_; }
  const VectorXd& upper() const override { return upper_; }
  const VectorXd& row_lower() const override { return row_lower_; }
  const VectorXd& row_upper() const override { return row_upper_; }
  const SparsityPattern& jacobian_pattern() const override { return program_.jacobian_pattern(); }
  const SparsityPattern& hessian_pattern() const override { return program_.hessian_pattern(); }
  SparsityPattern curvature_pattern() const override { return program_.curvature_pattern(); }
  bool supports(Curvature curvature) const override { return program_.supports(curvature); }
  bool has_curved_cost() const override { return program_.has_curved_cost(); }
  bool is_linear_quadratic() const override { return program_.is_linear_quadratic(); }
  bool is_affine(int row) const override { return program_.is_affine(row); }
  qp::StageStructure stages() const override { return program_.stages(); }
  int first_slack() const override { return program_.first_slack(); }

  bool objective(const double* w, double& f) override;
  bool gradient(const double* w, double* gradient) override;
  bool constraints(const double* w, double* g) override;
  bool jacobian(const double* w, double* entries) override;
  void prepare_derivatives(const double* w, double sigma, const double* lambda,
                           Curvature curvature) override;
  bool hessian(const double* w, double sigma, const double* lambda, double* entries,
               Curvature curvature) override;

  std::string describe_variable(int i) const override { return program_.describe_variable(i); }
  std::string describe_row(int i) const override { return program_.describe_row(i); }

 private:
  const double* unscaled(const double* w);

  NonlinearProgram& program_;
  ProgramScale scale_;
  VectorXd lower_, upper_, row_lower_, row_upper_, w_, lambda_;
};

}  // namespace saltus
