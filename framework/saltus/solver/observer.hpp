// Observes the iterations of a solve, and can stop it.
//
//     solve(car, {.observer = {.report = table_of_iterations(print)}});
#pragma once

#include <functional>
#include <limits>
#include <string>

namespace saltus {

/// State of a solve after an iteration. NaN: the method has no such value. All values except the
/// cost are in the scale in which the program is solved.
struct SolverIteration {
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

/// Callbacks of a solve. Empty callbacks cost nothing.
struct SolveObserver {
  /// Called after each iteration on the solving thread.
  std::function<void(const SolverIteration&)> report = {};
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
std::string row_of_iterations(const SolverIteration& iteration);
/// Passes a table to `print` line by line, with the header before every `header_every` rows.
std::function<void(const SolverIteration&)> table_of_iterations(
    std::function<void(const std::string& line)> print, int header_every = 10);

}  // namespace saltus
