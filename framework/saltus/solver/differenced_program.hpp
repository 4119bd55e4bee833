// A program whose second derivatives are finite differences of the first ones. It serves functions
// without second derivatives: flows through events, whose Jacobian jumps, and user code.
#pragma once

#include <optional>
#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// The curvature to solve with: the requested one, or the exact one if the program does not support
/// it. Empty if the program supports neither; second derivatives are then finite differences.
/// Gauss-Newton is not a substitute for exact curvature: it is zero if no cost is a sum of squares.
std::optional<Curvature> supported_curvature(const NonlinearProgram& program, Curvature asked);

/// All functions except the Hessian are those of `program`, which must outlive this object. The
/// Hessian consists of central differences of the gradient of the Lagrangian. Their error is
/// (step)^2 = 1e-8 plus 1e4 times the noise of the first derivatives. Variables of different
/// Hessian blocks are perturbed together. Variables coupled to many others, such as durations, are
/// perturbed alone.
class DifferencedProgram final : public NonlinearProgram {
 public:
  explicit DifferencedProgram(NonlinearProgram& program);

  int variables() const override { return program_.variables(); }
  int rows() const override { return program_.rows(); }
  const VectorXd& lower() const override { return program_.lower(); }
  const VectorXd& upper() const override { return program_.upper(); }
  const VectorXd& row_lower() const override { return program_.row_lower(); }
  const VectorXd& row_upper() const override { return program_.row_upper(); }
  const SparsityPattern& jacobian_pattern() const override { return program_.jacobian_pattern(); }
  const SparsityPattern& hessian_pattern() const override { return hessian_pattern_; }
  bool supports(Curvature curvature) const override { return curvature == Curvature::exact; }
  bool has_curved_cost() const override { return program_.has_curved_cost(); }
  bool is_linear_quadratic() const override { return program_.is_linear_quadratic(); }
  bool is_affine(int row) const override { return program_.is_affine(row); }
  qp::StageStructure stages() const override { return program_.stages(); }
  int first_slack() const override { return program_.first_slack(); }

  bool objective(const double* w, double& f) override { return program_.objective(w, f); }
  bool gradient(const double* w, double* g) override { return program_.gradient(w, g); }
  bool constraints(const double* w, double* g) override { return program_.constraints(w, g); }
  bool jacobian(const double* w, double* entries) override { return program_.jacobian(w, entries); }
  bool hessian(const double* w, double sigma, const double* lambda, double* entries,
               Curvature curvature) override;

  std::string describe_variable(int i) const override { return program_.describe_variable(i); }
  std::string describe_row(int i) const override { return program_.describe_row(i); }

 private:
  bool lagrangian_gradient(double sigma, const double* lambda, VectorXd& result);

  NonlinearProgram& program_;
  SparsityPattern hessian_pattern_;
  std::vector<int> colour_of_;  // variables of one colour are perturbed together
  std::vector<char> is_hub_;
  int colours_ = 0;
  VectorXd w_, above_, below_;
  std::vector<double> jacobian_;
};

}  // namespace saltus
