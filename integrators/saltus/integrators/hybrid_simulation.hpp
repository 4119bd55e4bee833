// Simulation of a hybrid system: states at requested times, every event with its derivatives, and
// the derivative of the end. The mode is carried along from interval to interval.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/event_integrator.hpp"

namespace saltus {

/// What one simulation through events gave.
struct HybridSimulation {
  IntegrationStatus status = IntegrationStatus::success;  ///< whether it came to its end
  std::string message;  ///< a sentence; on failure with time, mode and event
  int intervals = 0;    ///< integrated successfully
  VectorXd times;       ///< as given, n + 1
  MatrixXd states;      ///< nx x (n + 1), behind an event at that time; NaN after a failure
  MatrixXd costs;       ///< nq x (n + 1), accumulated from the first time on
  std::vector<HybridEvent> events;  ///< in the order of time
  std::string end_mode;             ///< in force at the end
  MatrixXd derivative;              ///< d (x | q)(end) / d (x0 | p), (nx + nq) x (nx + np)
};

/// Integrates `problem`, which must have events, from times[0] to times[n], which must not
/// decrease, from x0 (nx), with the inputs of `coefficients` (coefficients() x n) between times.
/// `start_mode` names the mode at the start; empty: the one that follows from the state.
/// Throws DefinitionError when sizes do not match, times decrease, the mode does not exist or the
/// scheme does not handle events.
HybridSimulation simulate_hybrid(const IntegratorChoice& scheme, IntervalProblem problem,
                                 const VectorRef& x0, const VectorRef& times,
                                 const Eigen::Ref<const MatrixXd>& coefficients,
                                 const VectorRef& parameters, const std::string& start_mode = {});

}  // namespace saltus
