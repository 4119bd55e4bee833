// What the verifier found in a plan: the numbers behind Solution::ok(), in the user's units.
#pragma once

#include <string>
#include <vector>

namespace saltus {

/// The largest miss of one kind, compared with its tolerance.
struct VerifiedMiss {
  std::string phase = {};  ///< name of the phase; empty: of the whole problem
  std::string term = {};   ///< name of the term, state, link or integral
  double time = 0.0;       ///< s, where the miss is largest
  double amount = 0.0;     ///< in the units of the term; 0: none
  double tolerance = 0.0;  ///< in the same units

  /// True if the miss is larger than its tolerance, or not a number.
  bool is_beyond() const { return !(amount <= tolerance); }
};

/// How far the planned state at the end of an interval is from the solution of the differential
/// equation that starts at the planned state at its start.
struct VerifiedDefect {
  std::string phase;      ///< where the defect is largest
  int state = 0;          ///< number of the state there
  double time = 0.0;      ///< s, start of the interval
  double largest = 0.0;   ///< relative to max(unit of the state, |state|)
  double absolute = 0.0;  ///< the same in the state's units
  double sum = 0.0;       ///< largest sum over the intervals of a phase, relative
};

/// What the planned inputs alone do: integrated from the planned start, through jumps, to the end.
struct VerifiedOpenLoop {
  bool completed = false;  ///< false: the integration failed, or a phase could not be verified
  double states = 0.0;     ///< largest deviation from the plan at the end of a phase, relative
  int state = 0;           ///< number of the state there
  std::string phase;       ///< where that is
  double time = 0.0;       ///< s, end of that phase
  /// The end constraint that the inputs alone miss most.
  VerifiedMiss end;
  /// Largest factor by which an error of the state at the start grows along the plan, in units of
  /// the states: the largest singular value of the flow.
  double growth = 1.0;
};

/// The cost, by the verifier's own quadrature.
struct VerifiedCost {
  bool compared = false;    ///< false: a phase could not be verified
  double value = 0.0;       ///< in the user's units
  double difference = 0.0;  ///< to the reported cost, relative to what it consists of
};

/// Result of a verification. Uses nothing but the definition of the problem and the plan.
struct Verification {
  VerifiedMiss between_nodes;  ///< of path constraints over all time
  VerifiedMiss at_nodes;       ///< of all hard rows where the program has them
  VerifiedDefect defect;       ///< of the integration
  VerifiedOpenLoop open_loop;  ///< of the inputs alone
  VerifiedCost cost;           ///< of the plan
  std::string integrator;      ///< which schemes the verifier used
  /// A sentence for everything that could not be verified; empty: all was.
  std::vector<std::string> not_verified;
  double seconds = 0.0;  ///< wall clock of the verification
};

}  // namespace saltus
