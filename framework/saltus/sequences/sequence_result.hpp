// What a search over sequences of modes is asked for, and what it says of the one it found.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

/// What is known of the best sequence.
enum class Guarantee {
  optimal,       ///< no allowed sequence costs less than lower_bound, and the gap is closed
  bounded,       ///< the gap is open; no allowed sequence costs less than lower_bound
  enumerated,    ///< every allowed sequence was solved to a local optimum, or ruled out by a prefix
                 ///< that was: nothing is known of optima that the solver does not find
  incomplete,    ///< the search was stopped, and nothing is known of what it did not look at
  infeasible,    ///< there is no feasible sequence: each was excluded by its times, or by a proof
                 ///< (Farkas) for a convex program
  inconclusive,  ///< no sequence was found, but not all were proved infeasible; or the sequence
                 ///< that was found could not be confirmed
  contradicted,  ///< the search and a solve of a sequence disagree; the message has both numbers
};
/// One sentence.
const char* describe(Guarantee guarantee);

/// How sequences of modes are searched.
struct SearchOptions {
  int phases = 0;   ///< exactly so many, a horizon in samples; 0: see at_most
  int at_most = 0;  ///< up to so many phases, one more than switches; 0: no limit but time
  /// Relative to the cost: sequences that are not better by more are not looked for. Convex
  /// problems: at least twice `tolerance`.
  double gap = 1e-6;
  /// Absolute floor of what the gap is relative to, in units of the cost: smaller costs count as
  /// this large. 0: 1e-6, or in convex problems the largest of a millionth of the largest
  /// coefficient of all costs, in nominal units, and 1e-4 of the cost of the relaxed problem.
  double least_cost = 0.0;
  double deadline = infinity;  ///< wall clock, s: then the best so far
  long max_nodes = 1000000;    ///< programs solved

  // Convex problems.
  double tolerance = 1e-8;  ///< of the quadratic programs, see QpOptions
  bool warm = true;         ///< a node starts at its parent's point; false: to compare
  /// The winner is solved again as an OptimalControlProblem, and if there is none a few sequences
  /// are tried. A result that disagrees with the search is Guarantee::contradicted.
  bool confirm = true;

  // All others.
  int intervals_per_phase = 30;      ///< of every phase
  IntegratorChoice integrator = {};  ///< empty: zero_order_hold() (convex), runge_kutta4()
  /// Running and end costs are never negative, so that a prefix costs no more than what it begins:
  /// prefixes that cost more than the best sequence are ruled out.
  bool costs_are_nonnegative = false;
};

/// What a search over sequences gave.
struct SequenceResult {
  Guarantee guarantee = Guarantee::infeasible;  ///< how much is known of it
  std::vector<std::string> sequence;            ///< names of the modes; empty: none was found
  std::vector<int> modes;                       ///< the same by number
  double cost = infinity;                       ///< of the best sequence
  double lower_bound = -infinity;  ///< on the cost of every allowed sequence; convex problems only
  double least_cost = 1e-6;        ///< smaller costs count as this large in gap()
  std::string message;             ///< a sentence

  Solution solution;  ///< of the sequence; convex problems: with SearchOptions::confirm
  /// Convex problems: state at the start of every phase and at the end of the last one, input of
  /// every phase.
  std::vector<VectorXd> states, inputs;

  long nodes = 0;        ///< programs solved
  long infeasible = 0;   ///< of these
  long unresolved = 0;   ///< of these: the solver failed; the bound of what they began in counts
  long reused = 0;       ///< leaves taken over from the last tick
  long iterations = 0;   ///< of the solver, in all
  double seconds = 0.0;  ///< wall clock
  // Convex problems, s of CPU time: all of it, and what of it the quadratic programs took.
  double cpu_seconds = 0.0, solver_seconds = 0.0;  ///< processor time: of all, of solvers, s

  /// Whether there is a sequence at all.
  bool found() const { return !sequence.empty(); }
  /// Relative to the cost, or to least_cost where the cost is smaller; infinite without a bound.
  double gap() const;
};

}  // namespace saltus
