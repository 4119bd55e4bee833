// Change of one number of a problem: a bound, a time, a value.
#pragma once

#include <string>

#include "saltus/ocp/problem.hpp"

namespace saltus {

/// One number of a definition and its change.
struct ProblemChange {
  /// Kind of the number.
  enum class Kind {
    term,        ///< bounds of a hard constraint
    state,       ///< bounds of a state
    input,       ///< bounds of an input
    integral,    ///< limits of an integral
    link,        ///< limits of a link
    duration,    ///< of a phase in seconds: fixed, or a bound of a free one
    total_time,  ///< its bounds in seconds
    event,       ///< its time in the schedule in seconds
    parameter,   ///< data, or a bound of an unknown
    start        ///< initial state, or a bound of a free one
  };
  /// Side that moves; equal sides move together.
  enum class Side { lower, upper };

  Kind kind = Kind::term;   ///< kind of the number
  int phase = 0;            ///< not read for links, events and the total time
  std::string name = {};    ///< name of the term, integral, link, event or parameter
  int component = 0;        ///< row of a term or link; entry of a parameter, state or input
  Side side = Side::upper;  ///< side of bounds
  double by = 0.0;          ///< added amount, in the units of the number
};

/// Name of the kind: "term", "duration".
const char* describe(ProblemChange::Kind kind);
/// Returns the changed problem. Throws DefinitionError if the number does not exist.
OptimalControlProblem changed(const OptimalControlProblem& problem, const ProblemChange& change);
/// The number before the change. Throws DefinitionError if it does not exist.
double value_before(const OptimalControlProblem& problem, const ProblemChange& change);
/// "with the upper bound of input 0 in phase 'ride' at 4.2 in place of 3"
std::string describe(const OptimalControlProblem& problem, const ProblemChange& change);

}  // namespace saltus
