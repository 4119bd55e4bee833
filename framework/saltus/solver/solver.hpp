// Interface between problems and solvers: options in, a status and a point out.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "saltus/core/clock.hpp"
#include "saltus/qp/qp_result.hpp"
#include "saltus/solver/nonlinear_program.hpp"
#include "saltus/solver/optimum_check.hpp"

namespace saltus {

// Observes the iterations of a solve, and can stop it.
//
//     solve(car, {.observer = {.report = table_of_iterations(print)}});

/// Callbacks of a solve. Empty callbacks cost nothing.
struct SolveObserver {
  /// State of a solve after an iteration. NaN: the method has no such value. All values except the
  /// cost are in the scale in which the program is solved.
  struct Iteration {
    int number = 0;             ///< 0: the start
    bool is_restoring = false;  ///< true in the restoration phase, which reduces the violation
    double cost = 0.0;          ///< cost of the program; in the restoration phase its objective
    double violation = 0.0;     ///< largest violation of a row or bound
    double stationarity = 0.0;  ///< largest entry of the gradient of the Lagrangian
    double barrier = std::numeric_limits<double>::quiet_NaN();  ///< barrier parameter mu
    double step = 0.0;                                          ///< largest entry of the full step
    double regularisation = 0.0;  ///< shift of the diagonal of the Hessian
    double step_length = 0.0;     ///< fraction of the step taken, 0 to 1
    /// Step length of the bound multipliers.
    double dual_step_length = std::numeric_limits<double>::quiet_NaN();
  };

  /// Called after each iteration on the solving thread.
  std::function<void(const Iteration&)> report = {};
  /// Called after each iteration. True ends the solve with the current point and the status
  /// `interrupted`.
  std::function<bool()> should_stop = {};

  /// True if a stop callback is set and requests a stop.
  bool wants_stop() const { return should_stop && should_stop(); }
};

/// The same observer for a program whose cost was divided by `factor`.
SolveObserver with_cost_times(const SolveObserver& observer, double factor);

/// Header and row of an iteration table, without line ends. Columns: number (r: restoration), cost,
/// violation, stationarity, lg(mu), step, regularisation, step lengths.
std::string header_of_iterations();
std::string row_of_iterations(const SolveObserver::Iteration& iteration);
/// Passes a table to `print` line by line, with the header before every `header_every` rows.
std::function<void(const SolveObserver::Iteration&)> table_of_iterations(
    std::function<void(const std::string& line)> print, int header_every = 10);

/// Reason why a solve ended. A solve that does not converge returns a status and never throws.
enum class SolveStatus {
  optimal,
  acceptable,  ///< a looser tolerance was met and progress stopped
  feasible,    ///< one step was taken: it satisfies all rows and bounds, but is not shown to be an
               ///< optimum
  step_taken,  ///< one step was taken; it violates the rows, or they are not checked yet
  /// An optimum of the program, but not of the problem, because the grid is too coarse: path
  /// constraints are violated between the nodes, or the integration error is too large.
  coarse_grid,
  /// An optimum of the program, but not of the problem: at the end of a phase its guard crosses
  /// zero in the wrong direction, or it has already crossed zero.
  wrong_crossing,
  /// The first-order conditions hold, but the cost decreases along a direction and its negative: a
  /// saddle point or a maximum.
  no_minimum,
  /// No point was found that satisfies the constraints. Their violation seems to have a local
  /// minimum where the solve stopped. Solution::message says if infeasibility is proved.
  infeasible,
  unbounded,  ///< the cost is unbounded below
  iteration_limit,
  time_limit,         ///< wall-clock limit
  interrupted,        ///< stopped by SolveObserver::should_stop
  evaluation_failed,  ///< a function could not be evaluated at the start or during the solve
  numerical_failure,  ///< the linear algebra or the line search failed
  invalid_problem,    ///< too few degrees of freedom, inconsistent bounds, bad options
};
/// Describes the status in one sentence.
const char* describe(SolveStatus status);
/// Converts the status of a quadratic program that is the whole problem.
SolveStatus to_solve_status(qp::QpStatus status);
/// True if the solve converged, or took the single requested step and satisfies all rows and
/// bounds.
inline bool is_success(SolveStatus s) {
  return s == SolveStatus::optimal || s == SolveStatus::acceptable || s == SolveStatus::feasible;
}

/// Result of a solve.
struct NlpResult {
  /// Rows and bounds that no value of the variables satisfies.
  struct Contradiction {
    int row = -1;         ///< row of the program
    int other_row = -1;   ///< row that `row` contradicts, or
    int variable = -1;    ///< variable whose bounds it contradicts; both -1: it depends on no free
                          ///< variable
    double amount = 0.0;  ///< violation of its bounds while the others hold
  };

  SolveStatus status = SolveStatus::invalid_problem;  ///< reason why the solve ended
  NlpPoint point;                              ///< the last iterate, also if the solve failed
  double objective = 0.0;                      ///< cost at the point
  int iterations = 0;                          ///< total of all attempts, including failed ones
  double seconds = 0.0;                        ///< wall-clock time of all attempts
  KktCheck::Residual kkt;                      ///< recomputed from the program
  std::optional<Contradiction> contradiction;  ///< rows that no point satisfies, if known
  /// Multipliers of affine rows prove that no point satisfies them and the bounds.
  bool is_proved_infeasible = false;
  std::string hessian;  ///< exact, Gauss-Newton, differenced or limited-memory BFGS
};

/// A solver of sparse nonlinear programs. It may keep work space between solves of programs with
/// the same patterns. It prints only if its options request it.
class Solver {
 public:
  virtual ~Solver() = default;
  /// `start` needs w; multipliers may be empty. With `warm`, they are used.
  virtual NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) = 0;
  /// Later solves stop at this time or at their own time limit; max(): no deadline. Solvers that
  /// cannot be stopped ignore it.
  virtual void set_deadline(WallClock::time_point deadline) { (void)deadline; }
  /// Sets the observer of later solves. Solvers without observer support ignore it.
  void set_observer(SolveObserver observer) { observer_ = std::move(observer); }
  /// The observer that was set, or an empty one.
  const SolveObserver& observer() const { return observer_; }
  /// Requested scaled KKT error.
  virtual double tolerance() const { return 1e-8; }
  /// True if it solves stage by stage and needs the rows that define stages.
  virtual bool keeps_stages() const { return false; }
  /// Name of the solver in messages and results.
  virtual std::string name() const = 0;

 private:
  SolveObserver observer_;
};

}  // namespace saltus
