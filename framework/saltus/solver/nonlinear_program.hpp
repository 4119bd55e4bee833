// The sparse nonlinear program as every solver sees it.
#pragma once

#include <string>

#include "saltus/core/primal_dual_point.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"
#include "saltus/model/function.hpp"
#include "saltus/qp/stage_structure.hpp"

namespace saltus {

/// min f(w) subject to lower <= w <= upper and row_lower <= g(w) <= row_upper, with patterns that
/// never change. Lagrangian: L = sigma f + lambda' g; a multiplier is positive where the upper
/// side of its row holds the cost up. Evaluations return false where the point cannot be evaluated.
class NonlinearProgram {
 public:
  virtual ~NonlinearProgram() = default;

  /// How many variables.
  virtual int variables() const = 0;
  /// How many rows.
  virtual int rows() const = 0;
  /// Of the variables.
  virtual const VectorXd& lower() const = 0;
  /// Of the variables.
  virtual const VectorXd& upper() const = 0;
  /// Of the rows.
  virtual const VectorXd& row_lower() const = 0;
  /// Of the rows.
  virtual const VectorXd& row_upper() const = 0;
  /// rows x variables.
  virtual const SparsityPattern& jacobian_pattern() const = 0;
  /// variables x variables, lower triangle.
  virtual const SparsityPattern& hessian_pattern() const = 0;
  /// Whether hessian() can deliver this kind of curvature.
  virtual bool supports(Curvature curvature) const = 0;

  /// Whether any cost has second derivatives of its own. A Gauss-Newton Hessian is zero without.
  virtual bool has_curved_cost() const { return true; }
  /// Whether the cost is at most quadratic and every row affine, whatever the data are: one
  /// quadratic program is then the whole problem.
  virtual bool is_linear_quadratic() const { return false; }
  /// Whether a row is affine in the variables, whatever the data are.
  virtual bool is_affine(int row) const {
    (void)row;
    return is_linear_quadratic();
  }
  /// Which variables and rows make up which stage. Throws DefinitionError: it has none.
  virtual StageStructure stages() const;
  /// Variables from here on only penalise violations of soft rows. Their weights say nothing about
  /// the size of the cost.
  virtual int first_slack() const { return variables(); }
  /// Changes whenever something other than bounds does on which evaluations depend; negative:
  /// changes are not counted, and evaluations must be repeated.
  virtual long revision() const { return -1; }

  /// Its cost at w.
  virtual bool objective(const double* w, double& f) = 0;
  /// Of the cost, one number per variable, at w.
  virtual bool gradient(const double* w, double* gradient) = 0;
  /// Rows at w.
  virtual bool constraints(const double* w, double* g) = 0;
  /// Entries of the rows' Jacobian in the order of its pattern, at w.
  virtual bool jacobian(const double* w, double* entries) = 0;
  /// Entries of the Hessian of the Lagrangian in the order of its pattern, at w.
  virtual bool hessian(const double* w, double sigma, const double* lambda, double* entries,
                       Curvature curvature) = 0;

  /// Announces that first and second derivatives at w will be asked for, the latter with these
  /// multipliers: programs that find both at once then do so.
  virtual void prepare_derivatives(const double* w, double sigma, const double* lambda,
                                   Curvature curvature);

  /// For messages: "phase 'flight', node 3, state 1".
  virtual std::string describe_variable(int i) const = 0;
  /// The same for a row.
  virtual std::string describe_row(int i) const = 0;

  /// Where the Lagrangian may be curved (lower triangle): more than hessian_pattern() where
  /// functions have no second derivatives.
  virtual SparsityPattern curvature_pattern() const { return hessian_pattern(); }
};

/// A point of a program; lambda belongs to the rows, z to the bounds.
using NlpPoint = PrimalDualPoint;

}  // namespace saltus
