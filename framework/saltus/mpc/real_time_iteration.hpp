// The real-time iteration: one quadratic model per tick, prepared before the measurement arrives
// and solved after it (Diehl, Bock, Schloeder 2005). The initial state enters as rows, so that the
// measurement changes only bounds. A linear-quadratic program is its own model: one solve is exact,
// and unchanged parts are not linearised again.
#pragma once

#include <memory>
#include <span>

#include "saltus/mpc/real_time_solver.hpp"
#include "saltus/qp/riccati_solver.hpp"
#include "saltus/solver/qp_method.hpp"

namespace saltus {

/// Options of the real-time iteration.
struct RealTimeIterationOptions {
  double tolerance = 1e-8;   ///< tolerance of the quadratic program
  int max_iterations = 100;  ///< iteration limit of a quadratic program
  /// Hessian of nonlinear programs; an exact one is convexified block by block. Gauss-Newton keeps
  /// only the curvature of the costs. If no cost is curved, as in minimum-time problems, or the
  /// program does not support it, the exact Hessian is used, or else differences of first
  /// derivatives. RealTimeSolver::name() reports which one.
  Curvature curvature = Curvature::gauss_newton;
  double convexity_floor = 1e-6;  ///< see NativeSolverOptions
  /// Empty: Riccati recursion over the stages of the program. A shooting program fills them
  /// directly, so that a measurement changes only the initial state of the first one.
  QpMethod qp = {};
  /// Kernels for compile-time stage sizes, see make_riccati_solver(). They must outlive the solver.
  std::span<const qp::RiccatiKernel> kernels = {};
};

/// For the given program only. It does not allocate after construction.
std::unique_ptr<RealTimeSolver> make_real_time_iteration(NonlinearProgram& program,
                                                         RealTimeIterationOptions options = {});

}  // namespace saltus
