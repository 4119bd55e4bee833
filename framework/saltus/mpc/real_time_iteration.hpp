// The real-time iteration: one quadratic model per tick, made before the measurement arrives and
// solved after it (Diehl, Bock, Schloeder 2005). The start of the problem stands in rows, so that
// the measurement only changes bounds. A linear-quadratic program is its own model: one solve is
// exact, and nothing is linearised again that did not change.
#pragma once

#include <memory>
#include <span>

#include "saltus/mpc/real_time_solver.hpp"
#include "saltus/qp/riccati_solver.hpp"
#include "saltus/solver/qp_method.hpp"

namespace saltus {

/// How a tick solves its program.
struct RealTimeIterationOptions {
  double tolerance = 1e-8;   ///< of the quadratic program
  int max_iterations = 100;  ///< of a quadratic program
  /// Hessian of nonlinear programs; an exact one is convexified block by block. Gauss-Newton keeps
  /// the curvature of the costs only: where no cost is curved, as in least time, and where the
  /// program does not support it, the exact one is used, and without that differences of first
  /// derivatives. RealTimeSolver::name() says which.
  Curvature curvature = Curvature::gauss_newton;
  double convexity_floor = 1e-6;  ///< see SqpOptions
  /// Empty: Riccati sweeps over the program's stages, which a shooting program fills directly, so
  /// that a measurement changes nothing but the start of the first one.
  QpMethod qp = {};
  /// Sizes of stages that those sweeps know at compile time, see make_riccati_solver(); they must
  /// outlive the solver.
  std::span<const qp::RiccatiKernel> kernels = {};
};

/// For the program given and no other. After construction nothing allocates.
std::unique_ptr<RealTimeSolver> make_real_time_iteration(NonlinearProgram& program,
                                                         RealTimeIterationOptions options = {});

}  // namespace saltus
