// The problem as the judge knows it: plain functions of numbers, simulated by CVODE, which is
// called directly. Nothing here uses the framework's integrators, transcription or derivatives.
#pragma once

#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus::corpus {

using Complex = std::complex<double>;

/// y = f(z) with z = (t | x | u), for numbers and for complex steps (derivatives without
/// cancellation).
struct OutsideFormula {
  int rows = 0;
  std::function<void(const double* z, double* y)> value;
  std::function<void(const Complex* z, Complex* y)> complex_value;
};

/// One constraint, a path constraint or one at the end of a phase.
struct OutsideRow {
  std::string name;
  OutsideFormula formula;
  std::vector<Bounds> bounds;  ///< one per row of the formula
  double from = 0.0;           ///< path constraints: start of the window, seconds of the phase
  double to = infinity;        ///< path constraints: end of the window, seconds of the phase
  bool nodes_only = false;     ///< a row that is soft, or that is promised at the nodes only

  /// The row's default tolerance: 1e-6 of the largest of 1 and its finite bounds.
  double tolerance(int i) const;
};

/// A phase as the judge knows it.
struct OutsidePhase {
  std::string name;
  int nx = 0, nu = 0;
  OutsideFormula field;
  OutsideFormula entry;  ///< x+ of (t | x- | no input); empty: the state goes on
  std::vector<OutsideRow> path, ends;
  std::vector<Bounds> input_bounds;  ///< nu
  Bounds duration;
  std::vector<OutsideFormula> running_costs, end_costs;
  double max_step =
      infinity;  ///< of the outside integrator, s: below the smallest feature of the path
};

/// One interval of a plan, copied out of a solution.
struct PlanPiece {
  int phase = 0;
  double start = 0.0, length = 0.0;  ///< s
  VectorXd state, end_state;         ///< the plan's own, before any jump
  VectorXd first_input, last_input;  ///< equal: constant over the interval
  bool is_linear = false;            ///< the input has two coefficients per entry

  VectorXd input(double fraction) const {
    return first_input + fraction * (last_input - first_input);
  }
};

/// What is wrong with a plan, in the user's units.
struct Miss {
  std::string what;        ///< term and time
  double amount = 0.0;     ///< in the term's units; 0: nothing
  double tolerance = 1.0;  ///< what is allowed

  bool is_broken() const { return !(amount <= tolerance); }
  double relative() const { return amount / tolerance; }
};

/// Results of CVODE along a plan.
struct OutsideCheck {
  bool simulated = true;  ///< false: CVODE gave up
  Miss path;              ///< the worst path constraint or input bound, from the plan's nodes
  Miss end;               ///< the worst end of a phase at the plan's own last node
  Miss open_loop_end;     ///< the worst end if the plan's inputs act from the start on
  Miss defect;            ///< the largest error of an interval, relative to the size of each state
  Miss stated_defect;     ///< the same, relative to what the framework asks of itself
  double cost = 0.0;      ///< from the plan's nodes
  double largest_state = 0.0;  ///< along the plan
};
OutsideCheck check_outside(const std::vector<OutsidePhase>& phases,
                           const std::vector<PlanPiece>& plan);

/// x at t1 from x at t0 with the piece's input, tolerance 1e-11; calls visit(from, to, at) for each
/// internal step, where at(t, x) is the dense output. False: CVODE gave up.
bool flow(const OutsidePhase& phase, const PlanPiece& piece, VectorXd& x,
          const std::function<void(double, double, const std::function<void(double, double*)>&)>&
              visit = {});

}  // namespace saltus::corpus
