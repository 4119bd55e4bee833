// Detects rows of a program that are redundant, repeated or contradictory.
//
// A variable is known if its bounds are equal, or if an affine equality determines it. A row that
// depends only on known variables is constant: it holds and is removed, or it is infeasible. An
// affine equality between two variables (an identity jump, a held input) merges them, so that rows
// at both ends of a jump can be compared. Among rows that are multiples of each other, and among
// rows and bounds on one variable, only the tightest sides are kept.
//
// A removed row has infinite sides. Sizes, patterns and stages are unchanged. A point of the
// reduced program is therefore a point of the original one, with zero multipliers of removed rows.
// Andersen and Andersen, Presolving in linear programming, Math. Program. 71, 1995. Nonlinear rows
// are compared at points near the start and checked after the solve.
//
// A nonlinear row that is constant where an equality with the same variables holds, such as
// sqrt(x^2 + y^2) = 1 next to x^2 + y^2 = 1, is removed. Both are compared at three points on the
// feasible set of the equality near the start, which Newton's method finds.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "saltus/solver/solve_in_scale.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// Options of presolve().
struct PresolveOptions {
  bool keeps_stages = false;       ///< does not change the rows that define stages
  bool compares_nonlinear = true;  ///< looks for multiples among nonlinear rows
};

/// The remaining sides, or a contradiction.
struct Presolve {
  VectorXd lower, upper;          ///< bounds of the variables, without sentinels such as 1e20
  VectorXd row_lower, row_upper;  ///< infinite if the side was removed
  std::vector<int> nonlinear;     ///< rows removed by comparison at points; to be checked
  bool has_changed = false;       ///< some side differs from that of the program
  std::optional<NlpResult::Contradiction> contradiction;  ///< rows that no point satisfies
};

/// Analyses a program near w. If it cannot be evaluated there, only sentinels are removed.
Presolve presolve(NonlinearProgram& program, const VectorXd& w,
                  const PresolveOptions& options = {});

/// A program with the sides that presolve() kept. The original program must outlive it, and its
/// data must not change meanwhile.
class PresolvedProgram final : public NonlinearProgram {
 public:
  /// `program` and `sides` must outlive this object.
  PresolvedProgram(NonlinearProgram& program, const Presolve& sides)
      : program_(program), sides_(sides) {}

  int variables() const override { return program_.variables(); }
  int rows() const override { return program_.rows(); }
  const VectorXd& lower() const override { return sides_.lower; }
  const VectorXd& upper() const override { return sides_.upper; }
  const VectorXd& row_lower() const override { return sides_.row_lower; }
  const VectorXd& row_upper() const override { return sides_.row_upper; }
  const SparsityPattern& jacobian_pattern() const override { return program_.jacobian_pattern(); }
  const SparsityPattern& hessian_pattern() const override { return program_.hessian_pattern(); }
  SparsityPattern curvature_pattern() const override { return program_.curvature_pattern(); }
  bool supports(Curvature curvature) const override { return program_.supports(curvature); }
  bool is_linear_quadratic() const override { return program_.is_linear_quadratic(); }
  bool is_affine(int row) const override { return program_.is_affine(row); }
  qp::StageStructure stages() const override { return program_.stages(); }
  int first_slack() const override { return program_.first_slack(); }
  bool has_curved_cost() const override { return program_.has_curved_cost(); }

  bool objective(const double* w, double& f) override { return program_.objective(w, f); }
  bool gradient(const double* w, double* g) override { return program_.gradient(w, g); }
  bool constraints(const double* w, double* g) override { return program_.constraints(w, g); }
  bool jacobian(const double* w, double* entries) override { return program_.jacobian(w, entries); }
  void prepare_derivatives(const double* w, double sigma, const double* lambda,
                           Curvature curvature) override {
    program_.prepare_derivatives(w, sigma, lambda, curvature);
  }
  bool hessian(const double* w, double sigma, const double* lambda, double* entries,
               Curvature curvature) override {
    return program_.hessian(w, sigma, lambda, entries, curvature);
  }

  std::string describe_variable(int i) const override { return program_.describe_variable(i); }
  std::string describe_row(int i) const override { return program_.describe_row(i); }

 private:
  NonlinearProgram& program_;
  const Presolve& sides_;
};

/// Solves the presolved program by `solve(reduced)` and returns the result for the original
/// program: point, multipliers and residual. A contradiction gives `infeasible` without a solve.
ScaledResult solve_presolved(const Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                             const std::function<ScaledResult(NonlinearProgram&)>& solve);

}  // namespace saltus
