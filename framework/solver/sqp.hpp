// Sequential quadratic programming: quadratic models of the program, solved one after the other.
//
// From w the solution w+ of the model gives the step d = w+ - w and the new multipliers. The step
// is judged by the l1 merit function (l1_merit.hpp), corrected to second order where the curvature
// of the rows alone makes it fail, and shortened where that does not help.
//
// Models have the exact Hessian and need not be convex: the QP solver finds a local solution by
// inertia correction (ipm_inertia.hpp) within a trust region, a box about w that follows the steps
// which were accepted, because a far solution of an indefinite model says nothing. Where no trust
// region gives a step downhill the model is convexified (convexify.hpp), and shifted further while
// that does not help. A model without a feasible point is relaxed by an l1 penalty (elastic mode),
// and where a convex model with a large penalty weight cannot reduce the violations the program is
// infeasible. Of cold starts the multipliers are estimated by least squares first.
//
// Nocedal and Wright, Numerical Optimization, 2nd ed., ch. 18; Fletcher, Practical Methods of
// Optimization, 2nd ed., sec. 14.4 (trust regions and elastic mode).
#pragma once

#include <memory>

#include "saltus/solver/qp_method.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

struct SqpOptions {
  double tolerance = 1e-8;   ///< scaled KKT error
  int max_iterations = 200;  ///< quadratic models; of a linear-quadratic program: of its QP solver
  double time_limit = 0.0;   ///< s of wall clock, 0: none
  /// Hessian of the Lagrangian, or Gauss-Newton; the one of the two that the program supports.
  Curvature curvature = Curvature::exact;
  /// Of the first step of a cold start: the largest change of a variable, in nominal magnitudes.
  /// Longer steps take durations to their bounds, from where other local optima are nearer.
  double initial_trust_radius = 1.0;
  /// Smallest eigenvalue after convexification, relative to the largest of its block.
  double convexity_floor = 1e-6;
  QpMethod qp = sparse_qp();
  /// Of elastic mode, whose programs have two variables more per row and no stages.
  QpMethod elastic_qp = sparse_qp();
};

/// A linear-quadratic program is one model, solved once.
std::unique_ptr<Solver> make_sqp(SqpOptions options = {});

}  // namespace saltus
