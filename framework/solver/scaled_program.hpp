// A program whose cost or rows are in units far from one, as solvers should see it.
#pragma once

#include <vector>

#include "saltus/solver/solver.hpp"

namespace saltus {

/// What the cost and each row are multiplied by; powers of two, so that nothing is rounded. Those
/// whose derivatives at the point measured lie within the usual range stay as they are: 1.
struct ProgramScale {
  double cost = 1.0;
  VectorXd rows;

  bool is_one() const { return cost == 1.0 && (rows.array() == 1.0).all(); }
};

/// By the largest first and second derivatives of the cost, and the largest first ones of each row,
/// at w. Rows with a slack that a stage solver eliminates keep the scale of their slack.
ProgramScale measure_scale(NonlinearProgram& program, const VectorXd& w);

/// The program times a scale: same variables, patterns and stages. The program must outlive it, and
/// its data must not change meanwhile.
class ScaledProgram final : public NonlinearProgram {
 public:
  ScaledProgram(NonlinearProgram& program, ProgramScale scale);

  /// Multipliers and cost from the one to the other.
  NlpPoint to_scaled(NlpPoint point) const;
  NlpPoint from_scaled(NlpPoint point) const;

  int variables() const override { return program_.variables(); }
  int rows() const override { return program_.rows(); }
  const VectorXd& lower() const override { return program_.lower(); }
  const VectorXd& upper() const override { return program_.upper(); }
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
  NonlinearProgram& program_;
  ProgramScale scale_;
  VectorXd row_lower_, row_upper_, lambda_;
};

/// Solves the program in the scale measured at its start; status, point and cost are those of the
/// program as it is, and so is the residual. `scaled` receives the residual in that scale, which is
/// what the solver's tolerance is about.
NlpResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                         bool warm, KktResidual& scaled);

}  // namespace saltus
