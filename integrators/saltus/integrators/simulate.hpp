// Open-loop simulation: states at requested times under given inputs that change at these times.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// What came out, up to the first interval that failed.
struct Simulation {
  IntegrationStatus status = IntegrationStatus::success;  ///< whether it came to its end
  int intervals = 0;                                      ///< integrated successfully
  VectorXd times;                                         ///< as given, n + 1
  MatrixXd states;  ///< nx x (n + 1); columns after a failure are NaN
  MatrixXd costs;   ///< nq x (n + 1), accumulated from the first time on
};

/// Integrates from times[0] to times[n], which must not decrease, starting at x0 (nx). Column k of
/// `coefficients` (coefficients() x n) is the input between times[k] and times[k + 1] in the shape
/// of the integrator's problem; each interval starts anew, so that steps in the input are exact.
/// Throws DefinitionError when sizes do not match or times decrease.
Simulation simulate(Integrator& integrator, const VectorRef& x0, const VectorRef& times,
                    const Eigen::Ref<const MatrixXd>& coefficients, const VectorRef& parameters);

}  // namespace saltus
