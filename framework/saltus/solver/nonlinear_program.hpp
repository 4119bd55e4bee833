// Interface of sparse nonlinear programs to all solvers.
#pragma once

#include <string>

#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"
#include "saltus/model/function.hpp"
#include "saltus/qp/qp_result.hpp"

namespace saltus {

/// min f(w) subject to lower <= w <= upper and row_lower <= g(w) <= row_upper, with constant
/// patterns. Lagrangian: L = sigma f + lambda' g. A multiplier is positive if the upper side of its
/// row is active. Evaluations return false if the functions cannot be evaluated at the point.
class NonlinearProgram {
 public:
  virtual ~NonlinearProgram() = default;

  /// Number of variables.
  virtual int variables() const = 0;
  /// Number of rows.
  virtual int rows() const = 0;
  /// Lower bounds of the variables.
  virtual const VectorXd& lower() const = 0;
  /// Upper bounds of the variables.
  virtual const VectorXd& upper() const = 0;
  /// Lower bounds of the rows.
  virtual const VectorXd& row_lower() const = 0;
  /// Upper bounds of the rows.
  virtual const VectorXd& row_upper() const = 0;
  /// Pattern of the Jacobian, rows x variables.
  virtual const SparsityPattern& jacobian_pattern() const = 0;
  /// Pattern of the Hessian, variables x variables, lower triangle.
  virtual const SparsityPattern& hessian_pattern() const = 0;
  /// True if hessian() supports this kind of curvature.
  virtual bool supports(Curvature curvature) const = 0;

  /// True if any cost has second derivatives. Otherwise a Gauss-Newton Hessian is zero.
  virtual bool has_curved_cost() const { return true; }
  /// True if the cost is at most quadratic and every row affine for all data. The problem is then a
  /// single quadratic program.
  virtual bool is_linear_quadratic() const { return false; }
  /// True if the row is affine in the variables for all data.
  virtual bool is_affine(int row) const {
    (void)row;
    return is_linear_quadratic();
  }
  /// Assignment of variables and rows to stages. Throws DefinitionError if the program has none.
  virtual qp::StageStructure stages() const;
  /// Index of the first slack. Variables from here on only penalise violations of soft rows. Their
  /// weights say nothing about the size of the cost.
  virtual int first_slack() const { return variables(); }
  /// A counter that changes with all data of evaluations except bounds. Negative: changes are not
  /// counted, and evaluations must be repeated.
  virtual long revision() const { return -1; }

  /// Computes the cost at w.
  virtual bool objective(const double* w, double& f) = 0;
  /// Computes the gradient of the cost at w, one entry per variable.
  virtual bool gradient(const double* w, double* gradient) = 0;
  /// Computes the rows at w.
  virtual bool constraints(const double* w, double* g) = 0;
  /// Computes the entries of the Jacobian of the rows at w, in the order of its pattern.
  virtual bool jacobian(const double* w, double* entries) = 0;
  /// Computes the entries of the Hessian of the Lagrangian at w, in the order of its pattern.
  virtual bool hessian(const double* w, double sigma, const double* lambda, double* entries,
                       Curvature curvature) = 0;

  /// Announces that first derivatives at w, and second derivatives with these multipliers, will be
  /// requested. Programs that compute both together do so now.
  virtual void prepare_derivatives(const double* w, double sigma, const double* lambda,
                                   Curvature curvature);

  /// Description of a variable for messages: "phase 'flight', node 3, state 1".
  virtual std::string describe_variable(int i) const = 0;
  /// Description of a row for messages.
  virtual std::string describe_row(int i) const = 0;

  /// Pattern of possible curvature of the Lagrangian (lower triangle). Larger than
  /// hessian_pattern() if functions have no second derivatives.
  virtual SparsityPattern curvature_pattern() const { return hessian_pattern(); }
};

/// A point of a program; lambda belongs to the rows, z to the bounds.
using NlpPoint = PrimalDualPoint;

}  // namespace saltus
