// A plan as input of the verifier: numbers only, independent of the transcription.
#pragma once

#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

/// One interval of a plan, between two nodes.
struct PlannedInterval {
  int phase = 0;          ///< index of the phase
  double start = 0.0;     ///< absolute time in seconds
  double length = 0.0;    ///< in seconds
  VectorXd state;         ///< at the start
  VectorXd coefficients;  ///< of the input: nu numbers, or 2 nu for linear inputs
  VectorXd end_state;     ///< at the end, before a jump

  /// Absolute time of the end in seconds.
  double end() const { return start + length; }
};

/// States and inputs of all phases, and the reported cost.
struct Plan {
  std::vector<PlannedInterval> intervals;  ///< in order of time
  std::vector<VectorXd> parameters;        ///< p of each phase, including unknowns
  std::vector<double> starts;              ///< of each phase, in seconds
  std::vector<double> durations;           ///< of each phase, in seconds
  double cost = 0.0;                       ///< as reported
  /// Part of `cost` that depends on the grid as well as on the problem (penalise_change).
  double grid_cost = 0.0;
};

}  // namespace saltus
