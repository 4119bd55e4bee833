// ARKODE: one-step methods of SUNDIALS, explicit or diagonally implicit, with adaptive or fixed
// steps.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Type of the Runge-Kutta method.
enum class ArkodeMethod {
  Explicit,           ///< embedded Runge-Kutta pairs, orders 2, 3, 4, 5, 6 and 8
  DiagonallyImplicit  ///< L-stable stages by Newton's method, orders 2, 3, 4 and 5
};

/// Options of arkode().
struct ArkodeOptions {
  ArkodeMethod method = ArkodeMethod::Explicit;  ///< type of the method
  int order = 5;                                 ///< order of the method
  double tolerance = 1e-9;  ///< relative, per local step; with fixed steps: of Newton's method
  /// Absolute tolerance, scaled as in CvodesOptions.
  double absolute_tolerance = 1e-12;
  int fixed_steps = 0;      ///< equal steps per interval; 0: adaptive steps
  long max_steps = 100000;  ///< per interval
};

/// Integrates the variational equations together with the state. Sensitivities are thus derivatives
/// of the steps taken. With the implicit method, they are accurate to the tolerance of Newton's
/// iteration, which shares one factorisation for state and sensitivities. With adaptive steps,
/// value() and jacobian() may take different steps, as with cvodes(). With fixed steps, they take
/// the same. There are no second derivatives. Throws DefinitionError for an order that does not
/// exist and for tolerances outside (0, 1).
IntegratorChoice arkode(ArkodeOptions options = {});

}  // namespace saltus
