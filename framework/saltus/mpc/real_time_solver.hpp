// The seam between the controller and its solvers: what can be done before the measurement, and
// what is left to do after it.
#pragma once

#include <memory>
#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/qp_result.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// What a solve came to; the point is the caller's.
struct TickResult {
  SolveStatus status = SolveStatus::invalid_problem;  ///< of the tick's program
  int iterations = 0;                                 ///< of the quadratic program or of the solver
  double objective = 0.0;                             ///< cost of the plan
  double kkt = infinity;                              ///< scaled residual, see KktResidual
  double violation = infinity;                        ///< largest one of a row or bound
  /// The last three are those of a quadratic model, which say little of the program.
  bool of_model = false;
};

/// Solves a program again and again within a deadline.
class RealTimeSolver {
 public:
  virtual ~RealTimeSolver() = default;
  /// Whatever does not need the measured state. `guess` is where the program will be solved.
  virtual void prepare(NonlinearProgram& program, const NlpPoint& guess) noexcept = 0;
  /// `point` holds the guess (with `warm` its multipliers count too) and receives the solution, or
  /// what there was of it when the deadline passed.
  virtual TickResult feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                              WallClock::time_point deadline) noexcept = 0;
  /// For messages and results.
  virtual std::string name() const = 0;
};

/// Any solver of nonlinear programs, in units in which numbers are of a usual size as solve() does,
/// and with residuals in those: everything is done after the measurement, and may allocate.
/// Interior-point methods for whole programs gain little from multipliers that are only near.
std::unique_ptr<RealTimeSolver> make_real_time_solver(std::unique_ptr<Solver> solver,
                                                      bool use_multipliers = false);

}  // namespace saltus
