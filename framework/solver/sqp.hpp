// Sequential quadratic programming: quadratic models of the program, solved one after the other.
//
// From w the solution w+ of the model gives the step d = w+ - w and the new multipliers. The step
// is shortened until the l1 merit function  phi = f + sum_i nu_i violation_i(w),  nu_i above
// |lambda_i|, falls as the model promises (Armijo); a full step that fails for the curvature of the
// rows alone is corrected to second order first.
//
// Models have the exact Hessian and need not be convex: the QP solver finds a local solution by
// inertia correction (ipm_inertia.hpp). Where that gives no step downhill the model is convexified
// (convexify.hpp), and shifted further while that does not help; then Newton's step on the surface
// of the active rows (active_set.hpp) may replace its step. A model without a feasible point is
// relaxed: violations are bought at a high price (elastic mode), and where a convex model cannot
// reduce them any more the program is infeasible.
//
// Nocedal and Wright, Numerical Optimization, 2nd ed., ch. 18.
#pragma once

#include <functional>
#include <memory>

#include "framework/qp/sparse_qp.hpp"
#include "framework/solver/solver.hpp"

namespace saltus {

struct Sqp {
  double tolerance = 1e-8;   ///< scaled KKT error
  int max_iterations = 200;  ///< quadratic models; of a linear-quadratic program: of its QP solver
  double time_limit = 0.0;   ///< s of wall clock, 0: none
  /// Hessian of the Lagrangian, or Gauss-Newton; the one of the two that the program supports.
  Curvature curvature = Curvature::exact;
  /// Smallest eigenvalue after convexification, relative to the largest of its block.
  double convexity_floor = 1e-6;
};

/// Makes a solver of quadratic programs with these patterns.
using QpSolverFactory = std::function<std::unique_ptr<QpSolver>(
    const SparsityPattern& hessian, const SparsityPattern& rows, const QpOptions& options)>;

/// A linear-quadratic program is one model, solved once. `relaxed_qp` makes the solver of elastic
/// mode, whose programs have two variables more per row and no stages; it is called when needed.
std::unique_ptr<Solver> make_solver(const Sqp& options, QpSolverFactory qp,
                                    QpSolverFactory relaxed_qp);

}  // namespace saltus
