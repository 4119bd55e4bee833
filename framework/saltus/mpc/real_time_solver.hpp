// Interface between the controller and its solvers: work before the measurement, and after it.
#pragma once

#include <memory>
#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/qp_result.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// Result of a solve; the caller owns the point.
struct TickResult {
  SolveStatus status = SolveStatus::invalid_problem;  ///< status of the program of the tick
  int iterations = 0;           ///< iterations of the quadratic program or of the solver
  double objective = 0.0;       ///< cost of the plan
  double kkt = infinity;        ///< scaled residual, see KktResidual
  double violation = infinity;  ///< largest violation of a row or bound
  /// The last three values are those of a quadratic model, which approximate the program only
  /// roughly.
  bool of_model = false;
};

/// Solves a program repeatedly within a deadline.
class RealTimeSolver {
 public:
  virtual ~RealTimeSolver() = default;
  /// Does all work that does not need the measured state. `guess` is the point of linearisation.
  virtual void prepare(NonlinearProgram& program, const NlpPoint& guess) noexcept = 0;
  /// `point` is the guess and receives the solution, or the last iterate at the deadline. With
  /// `warm`, its multipliers are used too.
  virtual TickResult feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                              WallClock::time_point deadline) noexcept = 0;
  /// Name of the solver in messages and results.
  virtual std::string name() const = 0;
};

/// Adapts any solver of nonlinear programs. Like solve(), it scales badly scaled programs;
/// residuals are in that scale. All work is done after the measurement and may allocate.
/// Interior-point methods for whole programs gain little from approximate multipliers.
std::unique_ptr<RealTimeSolver> make_real_time_solver(std::unique_ptr<Solver> solver,
                                                      bool use_multipliers = false);

}  // namespace saltus
