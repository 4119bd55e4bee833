// What explain() finds: what is missing, what soft terms give way, and what would help, in words
// and as data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/solve/problem_change.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/trajectory.hpp"

namespace saltus {

/// What is missing of one side of a term, wherever it acts: so far its bound would have to give.
struct Shortage {
  /// "term", "state", "integral", "link", "closing" or "total time".
  std::string kind = {};
  std::string phase = {};                                 ///< empty where it belongs to none
  std::string term = {};                                  ///< of a state's bounds "state 1"
  int component = 0;                                      ///< row of the term
  ProblemChange::Side side = ProblemChange::Side::upper;  ///< that is missed
  double amount = 0.0;                                    ///< in the term's own units, positive
  double nominal = 1.0;                                   ///< what counts as one of them
  double time = 0.0;                                      ///< s, where it is held up most
  double value = 0.0;                                     ///< there
  double bound = 0.0;                                     ///< that it misses
  bool is_exact = false;                                  ///< both bounds are one
  /// Whether it is missing wherever one looks: the program is linear-quadratic. Else it is missing
  /// near the guess.
  bool is_certain = false;

  /// "phase 'ride', term 'there'"
  std::string name() const;
  /// "2.5 too little at t = 2 s (2 where 4.5 is asked)"
  std::string miss() const;
  /// The sentence: name, amount, time, value and bound.
  std::string text() const;
};

/// A row of a soft term that gives way at the optimum, and why.
struct SoftShortage {
  /// How much at the optimum, where most; its side is that of the larger amount.
  Shortage missed;
  double price = 0.0;  ///< what all of it costs, both sides and wherever it acts
  /// So much is missing at least when all that gives way is held to its bounds, in units of the
  /// term; 0: it can hold. Empty: not known.
  std::optional<double> least = {};
  /// Of the problem in which all that gives way is hard, if it can be met.
  std::optional<double> cost_if_held = {};
  /// An L1 penalty of this weight holds it, together with those of the others that give way: tried.
  std::optional<double> weight_that_holds = {};
  double weight = 0.0;  ///< of its penalty now

  /// The sentence: name, amount, time and price.
  std::string text() const;
};

/// Changes of the problem after which it can be met.
struct Remedy {
  std::vector<ProblemChange> changes;  ///< all of them together
  std::string text;  ///< "with the duration of phase 'ride' 2.6 s in place of 2 s"
  /// Of the problem with the changes, solved: a remedy is one only if that worked.
  SolveStatus status = SolveStatus::invalid_problem;
  double cost = 0.0;  ///< of it
  /// Of the change over the value before, or over its nominal magnitude where that is zero.
  double effort = 0.0;
};

/// What explain() finds.
struct Explanation {
  /// Of the elastic program; only an optimum explains anything.
  SolveStatus status = SolveStatus::invalid_problem;
  /// sum of amounts over nominal values.
  double relaxation = 0.0;
  std::vector<Shortage> shortages;  ///< the largest first, relative to nominal values
  /// Of an optimum, where nothing is missing: the dearest first.
  std::vector<SoftShortage> gives_way;
  double cost = 0.0;  ///< of that optimum; 0 where none was looked for
  /// The cost that grows most if all that gives way is held, "phase 'ride', 'effort'": what it
  /// gives way to. Empty where that is not known.
  std::string gives_way_to;
  /// The least effort first; then the shortages themselves. Where nothing but soft terms cannot
  /// hold, what would let them.
  std::vector<Remedy> remedies;
  /// A phase whose own events make the motion jump, so that another guess may do; empty: none.
  std::string events_in;
  Trajectory trajectory;  ///< with the least relaxation; where soft terms give way, the optimum
  int solves = 0;         ///< of elastic programs and of changed problems
  double seconds = 0.0;   ///< wall clock

  /// Whether the least relaxation is known, and is one.
  bool ok() const { return is_success(status); }
  /// Whether something is missing.
  bool is_infeasible() const { return ok() && !shortages.empty(); }
  /// A sentence per shortage or soft term, and one with the remedies.
  std::string text() const;
};

}  // namespace saltus
