// The real-time iteration: one quadratic model per tick, prepared before the measurement arrives
// and solved after it (Diehl, Bock, Schloeder 2005). The initial state enters as rows, so that the
// measurement changes only bounds. A linear-quadratic program is its own model: one solve is exact,
// and unchanged parts are not linearised again.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/qp_result.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

// Interface between the controller and its solvers: work before the measurement, and after it.

/// Solves a program repeatedly within a deadline.
class RealTimeSolver {
 public:
  /// Result of a solve; the caller owns the point.
  struct Result {
    SolveStatus status = SolveStatus::invalid_problem;  ///< status of the program of the tick
    int iterations = 0;           ///< iterations of the quadratic program or of the solver
    double objective = 0.0;       ///< cost of the plan
    double kkt = infinity;        ///< scaled residual, see KktCheck::Residual
    double violation = infinity;  ///< largest violation of a row or bound
    /// True if the last three values are those of a quadratic model, which approximate the values
    /// of the program only roughly.
    bool of_model = false;
  };

  virtual ~RealTimeSolver() = default;
  /// Does all work that does not need the measured state. `guess` is the point of linearisation.
  virtual void prepare(NonlinearProgram& program, const NlpPoint& guess) noexcept = 0;
  /// `point` is the guess and receives the solution, or the last iterate at the deadline. With
  /// `warm`, its multipliers are used too.
  virtual Result feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                          WallClock::time_point deadline) noexcept = 0;
  /// Name of the solver in messages and results.
  virtual std::string name() const = 0;
};
/// Deprecated name.
using TickResult [[deprecated("use RealTimeSolver::Result; removed in 0.4")]] =
    RealTimeSolver::Result;

/// Adapts any solver of nonlinear programs. Like solve(), it scales badly scaled programs;
/// residuals are in that scale. All work is done after the measurement and may allocate.
/// Interior-point methods for whole programs gain little from approximate multipliers.
std::unique_ptr<RealTimeSolver> make_real_time_solver(std::unique_ptr<Solver> solver,
                                                      bool use_multipliers = false);

/// Options of the real-time iteration.
struct RealTimeIterationOptions {
  double tolerance = 1e-8;   ///< tolerance of the quadratic program
  int max_iterations = 100;  ///< iteration limit of a quadratic program
  /// Hessian of nonlinear programs; an exact one is convexified block by block. Gauss-Newton keeps
  /// only the curvature of the costs. If no cost is curved, as in minimum-time problems, or the
  /// program does not support Gauss-Newton, the exact Hessian is used. A program without second
  /// derivatives uses differences of first derivatives. RealTimeSolver::name() reports which one.
  Curvature curvature = Curvature::gauss_newton;
  double convexity_floor = 1e-6;  ///< see NativeSolverOptions
  /// Empty: Riccati recursion over the stages of the program. A shooting program fills them
  /// directly, so that a measurement changes only the initial state of the first one.
  QpMethod qp = {};
  /// Kernels for compile-time stage sizes, see qp::make_riccati_solver(). They must outlive the
  /// solver.
  std::span<const qp::RiccatiKernel> kernels = {};
};

/// For the given program only. It does not allocate after construction.
std::unique_ptr<RealTimeSolver> make_real_time_iteration(NonlinearProgram& program,
                                                         RealTimeIterationOptions options = {});

}  // namespace saltus
