// A program whose variables, cost or rows are in units far from one, as solvers should see it.
#pragma once

#include <vector>

#include "saltus/solver/solver.hpp"

namespace saltus {

/// What the cost, each row and each variable are multiplied by; powers of two, so that nothing is
/// rounded. Those of the usual size stay as they are: 1.
struct ProgramScale {
  double cost = 1.0;
  VectorXd rows;
  VectorXd variables = {};  ///< empty: all 1

  bool is_one() const {
    return cost == 1.0 && (rows.array() == 1.0).all() && (variables.array() == 1.0).all();
  }
};
/// 1 for a usual size, else the power of two that brings it near to 1.
double scale_for(double size);

/// Cost and rows by the largest first and second derivatives of the cost, and the largest first
/// ones of each row, at w, with the variables times what is given. Rows with a slack that a stage
/// solver eliminates keep the scale of their slack.
ProgramScale measure_scale(NonlinearProgram& program, const VectorXd& w, VectorXd variables = {});

/// The program times a scale: same patterns and stages. The program must outlive it, and
/// its data must not change meanwhile.
class ScaledProgram final : public NonlinearProgram {
 public:
  ScaledProgram(NonlinearProgram& program, ProgramScale scale);

  /// From the one to the other.
  NlpPoint to_scaled(NlpPoint point) const;
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
  bool is_linear_quadratic() const override { return program_.is_linear_quadratic(); }
  StageStructure stages() const override { return program_.stages(); }

  bool objective(const double* w, double& f) override;
  bool gradient(const double* w, double* gradient) override;
  bool constraints(const double* w, double* g) override;
  bool jacobian(const double* w, double* entries) override;
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

/// Solves the program in the scale measured at its start, with the variables times what is given;
/// status, point and cost are those of the program as it is, and so is the residual. `scaled`
/// receives the residual in that scale, which is what the solver's tolerance is about.
NlpResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                         bool warm, KktResidual& scaled, VectorXd variables = {});

}  // namespace saltus
