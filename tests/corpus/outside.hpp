// The problem as the judge reads it: plain functions of numbers, simulated by direct calls of
// CVODE. Nothing here uses the framework's integrators, transcription or derivatives.
#pragma once

#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus::corpus {

using Complex = std::complex<double>;

/// y = f(z) with z = (t | x | u), for real numbers and for complex steps (derivatives without
/// cancellation).
struct OutsideFormula {
  int rows = 0;
  std::function<void(const double* z, double* y)> value;
  std::function<void(const Complex* z, Complex* y)> complex_value;
};

/// A path constraint or a constraint at the end of a phase.
struct OutsideRow {
  std::string name;
  OutsideFormula formula;
  std::vector<Bounds> bounds;  ///< one per row of the formula
  double from = 0.0;           ///< path constraints: start of the window, seconds of the phase
  double to = infinity;        ///< path constraints: end of the window, seconds of the phase
  bool nodes_only = false;     ///< a soft row, or a row that is promised at the nodes only

  /// Default tolerance of the row: 1e-6 times the largest of 1 and its finite bounds.
  double tolerance(int i) const;
};

/// A phase as the judge reads it.
struct OutsidePhase {
  std::string name;
  int nx = 0, nu = 0;
  OutsideFormula field;
  OutsideFormula entry;  ///< x+ of (t | x- | no input); empty: continuous state
  std::vector<OutsideRow> path, ends;
  std::vector<Bounds> input_bounds;  ///< nu
  Bounds duration;
  std::vector<OutsideFormula> running_costs, end_costs;
  double max_step = infinity;  ///< step limit of the judge's integrator, s: below the smallest
                               ///< feature of the path
};

/// One interval of a plan, copied from a solution.
struct PlanPiece {
  int phase = 0;
  double start = 0.0, length = 0.0;  ///< s
  VectorXd state, end_state;         ///< states of the plan, before any jump
  VectorXd first_input, last_input;  ///< equal if the input is constant over the interval
  bool is_linear = false;            ///< the input has two coefficients per entry

  VectorXd input(double fraction) const {
    return first_input + fraction * (last_input - first_input);
  }
};

/// A violation of a plan, in the user's units.
struct Miss {
  std::string what;        ///< name of the term and time
  double amount = 0.0;     ///< in the term's units; 0: no violation
  double tolerance = 1.0;  ///< largest allowed amount

  bool is_broken() const { return !(amount <= tolerance); }
  double relative() const { return amount / tolerance; }
};

/// Results of CVODE along a plan.
struct OutsideCheck {
  bool simulated = true;  ///< false: CVODE failed
  Miss path;  ///< largest violation of a path constraint or input bound, simulated from the plan's
              ///< nodes
  Miss end;   ///< largest violation of an end condition at the plan's last node
  Miss open_loop_end;  ///< largest violation of an end condition if the plan's inputs run in open
                       ///< loop
  Miss defect;         ///< largest error of an interval, relative to the size of each state
  Miss stated_defect;  ///< the same, relative to the accuracy that the framework requires of itself
  double cost = 0.0;   ///< simulated from the plan's nodes
  double largest_state = 0.0;  ///< along the plan
};
OutsideCheck check_outside(const std::vector<OutsidePhase>& phases,
                           const std::vector<PlanPiece>& plan);

/// Integrates x from t0 to t1 with the piece's input and tolerance 1e-11. Calls visit(from, to, at)
/// for each internal step, where at(t, x) is the dense output. Returns false if CVODE fails.
bool flow(const OutsidePhase& phase, const PlanPiece& piece, VectorXd& x,
          const std::function<void(double, double, const std::function<void(double, double*)>&)>&
              visit = {});

}  // namespace saltus::corpus
