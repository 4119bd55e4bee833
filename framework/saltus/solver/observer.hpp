// Watching a solve: what every iteration has come to, and a way to end it.
//
//     solve(car, {.observer = {.report = table_of_iterations(print)}});
#pragma once

#include <functional>
#include <limits>
#include <string>

namespace saltus {

/// A solve after an iteration; NaN: the method has no such number. All in the scale in which the
/// program is solved, but for the cost.
struct SolverIteration {
  int number = 0;             ///< 0: the start
  bool is_restoring = false;  ///< towards a point that meets the rows, not towards the optimum
  double cost = 0.0;          ///< of the program; while restoring: of what is missing
  double violation = 0.0;     ///< largest of a row or bound
  double stationarity = 0.0;  ///< largest entry of the Lagrangian's gradient
  double barrier = std::numeric_limits<double>::quiet_NaN();  ///< parameter mu
  double step = 0.0;                                          ///< largest entry of the full step
  double regularisation = 0.0;                                ///< shift of the Hessian's diagonal
  double step_length = 0.0;  ///< part of the step that was taken, 0 to 1
  double dual_step_length = std::numeric_limits<double>::quiet_NaN();  ///< of bound multipliers
};

/// Unset, it costs nothing.
struct SolveObserver {
  /// Called after each iteration, by the thread that solves.
  std::function<void(const SolverIteration&)> report = {};
  /// Asked after each iteration; true: the solve ends with what there is, as `interrupted`.
  std::function<bool()> should_stop = {};

  /// Asks, if there is whom to ask.
  bool wants_stop() const { return should_stop && should_stop(); }
};

/// The same of a program whose cost was divided by `factor`.
SolveObserver with_cost_times(const SolveObserver& observer, double factor);

/// The columns of a table: number (r: restoring), cost, violation, stationarity, lg(mu), step,
/// regularisation, step lengths; and a row of it. Without line ends.
std::string header_of_iterations();
std::string row_of_iterations(const SolverIteration& iteration);
/// Hands a table to `print`, line by line, with the header before every `header_every` rows.
std::function<void(const SolverIteration&)> table_of_iterations(
    std::function<void(const std::string& line)> print, int header_every = 10);

}  // namespace saltus
