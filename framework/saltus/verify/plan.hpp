// A plan as the verifier takes it: numbers only, without anything of the transcription.
#pragma once

#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

/// One interval of a plan, between two nodes.
struct PlannedInterval {
  int phase = 0;          ///< index of the phase
  double start = 0.0;     ///< absolute time, s
  double length = 0.0;    ///< s
  VectorXd state;         ///< at its start
  VectorXd coefficients;  ///< of the input: nu numbers, or 2 nu where the input is linear
  VectorXd end_state;     ///< at its end, before a jump

  /// Absolute time of its end, s.
  double end() const { return start + length; }
};

/// States and inputs of all phases, and the cost that was reported for them.
struct Plan {
  std::vector<PlannedInterval> intervals;  ///< in the order of time
  std::vector<VectorXd> parameters;        ///< p of each phase, unknowns included
  std::vector<double> starts;              ///< of each phase, s
  std::vector<double> durations;           ///< of each phase, s
  double cost = 0.0;                       ///< as reported
  /// Part of `cost` that depends on the grid and not on the problem alone (penalise_change).
  double grid_cost = 0.0;
};

}  // namespace saltus
