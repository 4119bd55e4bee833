// A problem that differs from another in one number: a bound, a time, a value.
#pragma once

#include <string>

#include "saltus/ocp/problem.hpp"

namespace saltus {

/// One number of a definition, and by how much it moves.
struct ProblemChange {
  /// What it is a number of.
  enum class Kind {
    term,        ///< bounds of a hard constraint
    state,       ///< bounds of a state
    input,       ///< bounds of an input
    integral,    ///< limits of an integral
    link,        ///< limits of a link
    duration,    ///< of a phase: fixed, or a bound of a free one, s
    total_time,  ///< its bounds, s
    event,       ///< its time in the schedule, s
    parameter,   ///< data, or a bound of an unknown
    start        ///< the state at the start, or a bound of a free one
  };
  /// Which sides move; where both are equal, both do.
  enum class Side { lower, upper };

  Kind kind = Kind::term;   ///< what it is a number of
  int phase = 0;            ///< of links, events and the total time not read
  std::string name = {};    ///< of term, integral, link, event or parameter
  int component = 0;        ///< row of a term or link, entry of a parameter, state or input
  Side side = Side::upper;  ///< of bounds
  double by = 0.0;          ///< added, in the units of what changes
};

/// A word: "term", "duration".
const char* describe(ProblemChange::Kind kind);
/// Throws DefinitionError where there is no such thing.
OptimalControlProblem changed(const OptimalControlProblem& problem, const ProblemChange& change);
/// What `by` is added to. Throws DefinitionError where there is no such thing.
double value_before(const OptimalControlProblem& problem, const ProblemChange& change);
/// "with the upper bound of input 0 in phase 'ride' at 4.2 in place of 3"
std::string describe(const OptimalControlProblem& problem, const ProblemChange& change);

}  // namespace saltus
