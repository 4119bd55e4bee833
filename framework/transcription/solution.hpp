// What a solve of an optimal control problem returns.
#pragma once

#include <string>
#include <vector>

#include "framework/solver/solver.hpp"
#include "framework/transcription/trajectory.hpp"

namespace saltus {

/// How much of a soft constraint was given up.
struct SoftnessUse {
  std::string phase, term;
  double largest = 0.0;  ///< violation in the term's own units
  double time = 0.0;     ///< s, where it is largest
};

/// The share of a named cost in the total.
struct CostShare {
  std::string phase, term;
  double value = 0.0;
};

struct Solution {
  SolveStatus status = SolveStatus::invalid_problem;
  /// A sentence; when a constraint cannot be met it names phase, term and time, and by how much.
  std::string message;
  double cost = 0.0;
  Trajectory trajectory;
  std::vector<double> durations;  ///< of the phases, s
  std::vector<CostShare> costs;
  std::vector<SoftnessUse> softness;
  KktResidual kkt;  ///< recomputed from the program
  int iterations = 0;
  double seconds = 0.0;  ///< wall clock of the solver
  std::string method;    ///< integrator, cost rule, Hessian
  NlpPoint point;        ///< for warm starts
  /// d cost / d x0: the multipliers of the start, in physical units (costates up to sign
  /// conventions: positive where a larger start value costs more).
  VectorXd start_multipliers;

  bool ok() const { return is_success(status); }
};

}  // namespace saltus
