// The native solver of nonlinear programs, based on quadratic models of the program.
//
// Cold starts use the barrier method (barrier_run.hpp): one Newton step per model, accepted by a
// filter. Far from the solution models are inaccurate, and a step costs one factorisation.
//
// Warm starts, and methods without Newton systems, use sequential quadratic programming
// (sqp_run.hpp). It solves every model to convergence and so keeps the information in the
// multipliers. If it does not converge, the barrier method starts again.
//
// A linear-quadratic program is one model, solved once. Missing second derivatives are replaced by
// differences of first ones (differenced_program.hpp).
#pragma once

#include <memory>

#include "saltus/solver/qp_method.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// Options of the native solver.
struct NativeSolverOptions {
  /// Scaled KKT error. If the reported residual NlpResult::kkt exceeds the tolerance, the result is
  /// `acceptable` up to 100 times the tolerance and a failure above that.
  double tolerance = 1e-8;
  int max_iterations = 500;  ///< limit of quadratic models; for a linear-quadratic program, of QP
                             ///< iterations
  double time_limit = 0.0;   ///< wall-clock limit in seconds; 0: none
  /// Exact or Gauss-Newton Hessian of the Lagrangian. If the program does not support the requested
  /// one, the exact one is used, or else differences of first derivatives.
  Curvature curvature = Curvature::exact;
  /// Smallest eigenvalue after convexification, relative to the largest eigenvalue of its block.
  double convexity_floor = 1e-6;
  /// Largest change of a variable by the first SQP step of a cold start, in nominal magnitudes.
  /// Longer steps take durations to their bounds, close to other local optima.
  double initial_trust_radius = 1.0;
  QpMethod qp = sparse_qp();  ///< linear algebra of quadratic models and Newton systems
  /// Linear algebra of elastic mode. Its programs have two additional variables per row and no
  /// stages.
  QpMethod elastic_qp = sparse_qp();
};

/// The native solver: chooses the barrier method or sequential quadratic programming itself.
std::unique_ptr<Solver> make_native_solver(NativeSolverOptions options = {});

// Old names, removed in 0.4.
using SqpOptions [[deprecated("use NativeSolverOptions")]] = NativeSolverOptions;
[[deprecated("use make_native_solver")]] std::unique_ptr<Solver> make_sqp(
    NativeSolverOptions options = {});

}  // namespace saltus
