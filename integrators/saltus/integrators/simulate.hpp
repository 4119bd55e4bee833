// Open-loop simulation: states at requested times for inputs that may change at these times.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Result of simulate(), up to the first failed interval.
struct Simulation {
  IntegrationStatus status = IntegrationStatus::success;  ///< success, or the first failure
  int intervals = 0;                                      ///< number of successful intervals
  VectorXd times;                                         ///< the given times, n + 1
  MatrixXd states;  ///< nx x (n + 1); columns after a failure are NaN
  MatrixXd costs;   ///< nq x (n + 1), accumulated from the first time
};

/// Integrates from times[0] to times[n], which must not decrease, starting at x0 (nx). Column k of
/// `coefficients` (coefficients() x n) is the input between times[k] and times[k + 1], in the shape
/// of the integrator's problem. Each interval starts a new integration, so steps of the input are
/// exact. Throws DefinitionError if sizes do not match or times decrease.
Simulation simulate(Integrator& integrator, const VectorRef& x0, const VectorRef& times,
                    const Eigen::Ref<const MatrixXd>& coefficients, const VectorRef& parameters);

// Simulation of a hybrid system: states at requested times, all events with their derivatives, and
// the derivative of the end. The mode persists between intervals.

/// Result of simulate_hybrid().
struct HybridSimulation {
  IntegrationStatus status = IntegrationStatus::success;  ///< success, or the first failure
  std::string message;  ///< one sentence; on failure with time, mode and event
  int intervals = 0;    ///< number of successful intervals
  VectorXd times;       ///< the given times, n + 1
  MatrixXd states;      ///< nx x (n + 1), after an event at that time; NaN after a failure
  MatrixXd costs;       ///< nq x (n + 1), accumulated from the first time
  std::vector<HybridEvent> events;  ///< events in order of time
  std::string end_mode;             ///< active mode at the end
  MatrixXd derivative;              ///< d (x | q)(end) / d (x0 | p), (nx + nq) x (nx + np)
};

/// Integrates `problem`, which must have events, from times[0] to times[n] starting at x0 (nx).
/// Times must not decrease. `coefficients` (coefficients() x n) are the inputs between times.
/// `start_mode` is the mode at the start; if empty, it follows from the state. Throws
/// DefinitionError if sizes do not match, times decrease, the mode does not exist or the scheme
/// does not support events.
HybridSimulation simulate_hybrid(const IntegratorChoice& scheme, IntervalProblem problem,
                                 const VectorRef& x0, const VectorRef& times,
                                 const Eigen::Ref<const MatrixXd>& coefficients,
                                 const VectorRef& parameters, const std::string& start_mode = {});

}  // namespace saltus
