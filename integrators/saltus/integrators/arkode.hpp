// ARKODE: one-step integration of SUNDIALS, explicit or diagonally implicit, adaptive or with a
// fixed number of steps.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Explicit, for fields that are not stiff, or implicit.
enum class ArkodeMethod {
  Explicit,           ///< embedded Runge-Kutta pairs, orders 2, 3, 4, 5, 6 and 8
  DiagonallyImplicit  ///< L-stable stages by Newton's method, orders 2, 3, 4 and 5
};

/// What integrates with ARKODE's Runge-Kutta schemes.
struct ArkodeOptions {
  ArkodeMethod method = ArkodeMethod::Explicit;  ///< explicit or implicit
  int order = 5;                                 ///< of the scheme
  double tolerance = 1e-9;  ///< relative, on each local step; with fixed steps: of Newton's method
  /// Absolute, scaled as in CvodesOptions.
  double absolute_tolerance = 1e-12;
  int fixed_steps = 0;      ///< equal steps per interval; 0 means error control
  long max_steps = 100000;  ///< per interval
};

/// Sensitivities by the variational equations integrated together with the state: the derivative
/// of the very steps that were taken (for the implicit method up to the tolerance of Newton's
/// iteration, which treats state and sensitivities with one factorisation). With error control
/// value() and jacobian() may take different steps, as with cvodes(); with fixed steps they take
/// the same ones. No second derivatives. Throws DefinitionError for an order that does not exist
/// and for tolerances outside (0, 1).
IntegratorChoice arkode(ArkodeOptions options = {});

}  // namespace saltus
