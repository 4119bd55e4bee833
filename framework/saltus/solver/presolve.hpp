// Which rows of a program say nothing, say again what others say, or cannot be met at all?
//
// A variable is known if its bounds are equal, or if an affine equality leaves nothing else free. A
// row that reads known variables only is constant: it holds and is left out, or nothing meets it.
// An affine equality between two variables (an identity jump, a held input) makes them one, so that
// rows at both ends of a jump can be compared. Of rows that are multiples of one another, and of
// rows and bounds on one variable, only the tightest sides are kept.
//
// A row that is left out has infinite sides. Sizes, patterns and stages stay, so a point of the
// reduced program is one of the program, and its multipliers are valid there: those of what was
// left out are zero. Andersen and Andersen, Presolving in linear programming, Math. Program. 71,
// 1995; nonlinear rows are compared at points near the start, and checked after the solve.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "saltus/solver/solve_in_scale.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// What presolve() may do.
struct PresolveOptions {
  bool keeps_stages = false;       ///< leaves the rows that define stages as they are
  bool compares_nonlinear = true;  ///< looks for multiples among rows that are not affine
};

/// The sides that are left, or a contradiction.
struct Presolve {
  VectorXd lower, upper;          ///< of the variables, without sentinels such as 1e20
  VectorXd row_lower, row_upper;  ///< infinite where a side is left out
  std::vector<int> nonlinear;     ///< rows left out by comparison at points, to be checked
  bool has_changed = false;       ///< some side differs from that of the program
  std::optional<Contradiction> contradiction;  ///< nothing meets these rows
};

/// Looks at a program near w. Where it cannot be evaluated there, only sentinels are left out.
Presolve presolve(NonlinearProgram& program, const VectorXd& w,
                  const PresolveOptions& options = {});

/// A program with the sides that presolve() has left. The program must outlive it, and its data
/// must not change meanwhile.
class PresolvedProgram final : public NonlinearProgram {
 public:
  /// `program` and `sides` outlive this.
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
  StageStructure stages() const override { return program_.stages(); }
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

/// Solves what presolve() leaves of a program by `solve(reduced)`, and gives the result for the
/// program as it is: point, multipliers and residual. A contradiction is `infeasible`, without a
/// solve.
ScaledResult solve_presolved(const Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                             const std::function<ScaledResult(NonlinearProgram&)>& solve);

}  // namespace saltus
