// The seam between problems and solvers: options in, a status and a point out.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "saltus/core/clock.hpp"
#include "saltus/qp/qp_result.hpp"
#include "saltus/solver/kkt.hpp"
#include "saltus/solver/nonlinear_program.hpp"
#include "saltus/solver/observer.hpp"

namespace saltus {

/// Why a solve ended. A solve that does not converge is a result, never an exception.
enum class SolveStatus {
  optimal,
  acceptable,  ///< a looser tolerance was met and progress had stopped
  feasible,    ///< one step was taken: within all rows and bounds, but not shown to be an optimum
  step_taken,  ///< one step was taken, and nobody knows yet, or has seen, that it meets the rows
  /// An optimum of the program, but not of the problem: its grid is too coarse. Path constraints
  /// are violated between the nodes, or the integration is far off.
  coarse_grid,
  /// An optimum of the program, but not of the problem: where a phase ends its guard passes zero
  /// the other way, or it had passed before.
  wrong_crossing,
  /// The first-order conditions hold, but the cost falls from here along a direction and along its
  /// negative: a saddle or a maximum.
  no_minimum,
  infeasible,  ///< near the point reached nothing meets the constraints; where convex, nowhere
  unbounded,   ///< the cost falls without limit
  iteration_limit,
  time_limit,         ///< wall clock
  interrupted,        ///< SolveObserver::should_stop
  evaluation_failed,  ///< the functions could not be evaluated at the start or along the way
  numerical_failure,  ///< linear algebra or line search gave up
  invalid_problem,    ///< too few degrees of freedom, inconsistent bounds, bad options
};
/// One sentence.
const char* describe(SolveStatus status);
/// What a quadratic program's status means for the program that it is.
SolveStatus to_solve_status(QpStatus status);
/// Whether the solve did what it is for: it converged, or took the one step that was asked of it
/// and is within all rows and bounds.
inline bool is_success(SolveStatus s) {
  return s == SolveStatus::optimal || s == SolveStatus::acceptable || s == SolveStatus::feasible;
}

/// Rows and bounds that no choice of the variables meets.
struct Contradiction {
  int row = -1;         ///< of the program
  int other_row = -1;   ///< that `row` contradicts, or
  int variable = -1;    ///< whose bounds it contradicts; both -1: it reads nothing that is free
  double amount = 0.0;  ///< by which it misses its bounds while the others hold
};

/// What a solve gave.
struct NlpResult {
  SolveStatus status = SolveStatus::invalid_problem;  ///< how it ended
  NlpPoint point;                              ///< the last iterate, also when the solve failed
  double objective = 0.0;                      ///< cost at the point
  int iterations = 0;                          ///< of all attempts, also of those that failed
  double seconds = 0.0;                        ///< wall clock, of all attempts
  KktResidual kkt;                             ///< recomputed from the program
  std::optional<Contradiction> contradiction;  ///< why nothing meets the rows, if that is known
  std::string hessian;  ///< exact, Gauss-Newton, differenced or limited-memory BFGS
};

/// A solver of sparse nonlinear programs. It may keep work space between solves of programs with
/// the same patterns. Never prints unless its options ask for it.
class Solver {
 public:
  virtual ~Solver() = default;
  /// `start` needs w; multipliers may be empty. With `warm`, they are used.
  virtual NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) = 0;
  /// Later solves stop at this instant as well as at their own time limit; max(): never. Solvers
  /// that cannot be stopped ignore it.
  virtual void set_deadline(WallClock::time_point deadline) { (void)deadline; }
  /// Of later solves. Solvers that cannot be watched ignore it.
  void set_observer(SolveObserver observer) { observer_ = std::move(observer); }
  /// The one that was set, or one that does nothing.
  const SolveObserver& observer() const { return observer_; }
  /// The scaled KKT error that it is asked for.
  virtual double tolerance() const { return 1e-8; }
  /// Whether it solves stage by stage, and so needs the rows that define stages.
  virtual bool keeps_stages() const { return false; }
  /// For messages and results.
  virtual std::string name() const = 0;

 private:
  SolveObserver observer_;
};

}  // namespace saltus
