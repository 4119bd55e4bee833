// Our own solver of nonlinear programs: quadratic models of the program, one after the other.
//
// Cold starts: the barrier method (barrier_run.hpp), which takes one Newton step per model, judged
// by a filter. Far from the solution models are wrong anyway, and a step costs one factor.
//
// Warm starts, and methods without Newton's equations: sequential quadratic programming
// (sqp_run.hpp), which solves every model to its end and so keeps what the multipliers know. Where
// that does not converge the barrier method starts over.
//
// A linear-quadratic program is one model, solved once. Second derivatives that a program does not
// have are differences of the first ones (differenced_program.hpp).
#pragma once

#include <memory>

#include "saltus/solver/qp_method.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// How the own SQP and barrier method solve.
struct SqpOptions {
  /// Scaled KKT error. A result whose reported residual, NlpResult::kkt, is larger than the
  /// tolerance is `acceptable` up to 100 times the tolerance, and no success beyond.
  double tolerance = 1e-8;
  int max_iterations = 500;  ///< quadratic models; of a linear-quadratic program: of its QP solver
  double time_limit = 0.0;   ///< s of wall clock, 0: none
  /// Hessian of the Lagrangian, or Gauss-Newton. Where the program does not support the one asked
  /// for, the exact one is used, and without that differences of first derivatives.
  Curvature curvature = Curvature::exact;
  /// Smallest eigenvalue after convexification, relative to the largest of its block.
  double convexity_floor = 1e-6;
  /// Of models that are solved to their end, from a cold start: the largest change of a variable,
  /// in nominal magnitudes. Longer steps take durations to their bounds, from where other local
  /// optima are nearer.
  double initial_trust_radius = 1.0;
  QpMethod qp = sparse_qp();  ///< what solves quadratic models and Newton systems
  /// Of elastic mode, whose programs have two variables more per row and no stages.
  QpMethod elastic_qp = sparse_qp();
};

/// The own solver.
std::unique_ptr<Solver> make_sqp(SqpOptions options = {});

}  // namespace saltus
