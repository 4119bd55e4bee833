// Finds the best sequence of modes with its times and its trajectory, in one call.
//
//     const SequenceResult best = search(thermostat, {.phases = 15});
//
// Branch and bound solves convex problems in sampled time (sequence_search.hpp) and bounds the cost
// of all sequences. Other problems are enumerated, shorter sequences first. Each sequence is an
// OptimalControlProblem that starts from results of shorter ones. The result then has only the
// guarantee Guarantee::enumerated.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/sequences/mode_graph.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

// Options and result of a search over sequences of modes.

/// Options of a search over sequences.
struct SearchOptions {
  static constexpr int most_phases = 100'000;  ///< limit of phases and at_most

  int phases = 0;   ///< exact number of phases, a horizon in samples; 0: see at_most
  int at_most = 0;  ///< maximum number of phases, one more than switches; 0: limited by time only
  /// Relative optimality gap: the search ignores improvements below this fraction of the cost. In
  /// convex problems the search uses at least twice `tolerance`.
  double gap = 1e-6;
  /// Smallest cost to which the gap is relative, in units of the cost. 0 selects the default 1e-6.
  /// In convex problems, 0 selects the larger of two values: 1e-6 times the largest cost
  /// coefficient in nominal units, and 1e-4 times the cost of the relaxed problem.
  double least_cost = 0.0;
  double deadline = infinity;  ///< wall-clock limit, s; then returns the best sequence so far
  long max_nodes = 1000000;    ///< maximum number of programs solved

  // Convex problems.
  double tolerance = 1e-8;  ///< tolerance of the quadratic programs, see qp::QpOptions
  bool warm = true;         ///< start each node at its parent's point; false for comparisons
  /// Solves the best sequence again as an OptimalControlProblem, or a few sequences if none was
  /// found. A disagreement with the search gives Guarantee::contradicted.
  bool confirm = true;

  // Other problems.
  int intervals_per_phase = 30;      ///< intervals of each phase
  IntegratorChoice integrator = {};  ///< default: zero_order_hold() (convex), runge_kutta4()
  /// True if running and end costs are never negative. A prefix then costs no more than its
  /// continuations, and prefixes that cost more than the best sequence are excluded.
  bool costs_are_nonnegative = false;
};

/// Result of a search over sequences.
struct SequenceResult {
  /// Guarantee for the best sequence.
  enum class Guarantee {
    optimal,       ///< the gap is closed: no allowed sequence costs less than lower_bound
    bounded,       ///< the gap is open: no allowed sequence costs less than lower_bound
    enumerated,    ///< each allowed sequence was solved to a local optimum or excluded by a prefix;
                   ///< better local optima may exist
    incomplete,    ///< the search stopped early; unexplored sequences may be better
    infeasible,    ///< no sequence is feasible: each was excluded by its times, or for convex
                   ///< programs by a Farkas proof
    inconclusive,  ///< no sequence was found, but not all were proved infeasible; or the found
                   ///< sequence was not confirmed
    contradicted,  ///< the search and the solve of a sequence disagree; the message has both
                   ///< numbers
  };

  Guarantee guarantee = Guarantee::infeasible;  ///< guarantee for the sequence
  std::vector<std::string> sequence;            ///< names of the modes; empty: none was found
  std::vector<int> modes;                       ///< indices of the modes
  double cost = infinity;                       ///< cost of the sequence
  double lower_bound = -infinity;  ///< lower bound for all allowed sequences; convex problems only
  double least_cost = 1e-6;        ///< smaller costs count as this in gap()
  std::string message;             ///< one sentence

  Solution solution;  ///< plan of the sequence; convex problems: only with SearchOptions::confirm
  /// For convex problems: state at the start of every phase and at the end of the last one, and
  /// input of every phase.
  std::vector<VectorXd> states, inputs;

  long nodes = 0;        ///< number of programs solved
  long infeasible = 0;   ///< number of infeasible programs
  long unresolved = 0;   ///< number of failed solves; the bound of their parent applies
  long reused = 0;       ///< leaves reused from the last tick
  long iterations = 0;   ///< total solver iterations
  double seconds = 0.0;  ///< wall-clock time, s
  double cpu_seconds = 0.0, solver_seconds = 0.0;  ///< CPU time: total, QP solver, s; convex only

  /// True if a sequence was found.
  bool found() const { return !sequence.empty(); }
  /// Gap relative to the cost, or to least_cost if that is larger. Infinite without a bound.
  double gap() const;
};
/// One sentence about the guarantee.
const char* describe(SequenceResult::Guarantee guarantee);

/// Throws DefinitionError if the graph or the options are invalid (ModeGraph::check()). Set
/// SearchOptions::phases, or at_most for modes of free duration.
SequenceResult search(const ModeGraph& graph, const SearchOptions& options);

}  // namespace saltus
