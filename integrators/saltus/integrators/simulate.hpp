// Open-loop simulation: states at requested times for inputs that may change at these times.
#pragma once

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

}  // namespace saltus
