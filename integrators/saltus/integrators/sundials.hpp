// Integrators of SUNDIALS: the multistep methods CVODES and IDAS, and the one-step methods of
// ARKODE.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

// CVODES: variable-order multistep integration with forward sensitivities under error control. The
// reference for stiff problems and for offline use.

/// Options of cvodes().
struct CvodesOptions {
  /// Multistep method.
  enum class Method {
    Bdf,   ///< stiff problems; Newton with the analytic Jacobian and a dense factorisation
    Adams  ///< non-stiff problems; fixed-point iteration
  };

  /// Coupling of states and sensitivities.
  enum class Sensitivity {
    staggered,    ///< accepts the state step first, then all sensitivities
    simultaneous  ///< corrects both together
  };

  Method method = Method::Bdf;  ///< multistep method
  double tolerance = 1e-9;      ///< relative, per local step
  /// Absolute tolerance, multiplied by the nominal magnitude of each state
  /// (IntervalProblem::nominal_state). For the sensitivity to w_j it is also divided by the
  /// magnitude of w_j. For parameters, this is their value.
  double absolute_tolerance = 1e-12;
  Sensitivity sensitivity = Sensitivity::staggered;  ///< coupling of sensitivities
  long max_steps = 100000;                           ///< per interval
};
/// Deprecated name.
using CvodesMethod [[deprecated("use CvodesOptions::Method; removed in 0.4")]] =
    CvodesOptions::Method;
/// Deprecated name.
using CvodesSensitivity [[deprecated("use CvodesOptions::Sensitivity; removed in 0.4")]] =
    CvodesOptions::Sensitivity;

/// Integrates the interval in scaled time with running costs as additional states. Sensitivities
/// are included in error control. value() omits them and may take other steps than jacobian(), so
/// their end states agree to the tolerance, not to the last digit. The global error is typically 10
/// to 100 times the tolerance. Does not allocate after the first call of each kind, unless the
/// magnitude of a parameter or the length changes by a factor of two. There are no second
/// derivatives. Throws DefinitionError for a tolerance outside (0, 1) or an absolute one that is
/// negative or infinite.
IntegratorChoice cvodes(CvodesOptions options = {});

// ARKODE: one-step methods of SUNDIALS, explicit or diagonally implicit, with adaptive or fixed
// steps.

/// Options of arkode().
struct ArkodeOptions {
  /// Type of the Runge-Kutta method.
  enum class Method {
    Explicit,           ///< embedded Runge-Kutta pairs, orders 2, 3, 4, 5, 6 and 8
    DiagonallyImplicit  ///< L-stable stages by Newton's method, orders 2, 3, 4 and 5
  };

  Method method = Method::Explicit;  ///< type of the method
  int order = 5;                     ///< order of the method
  double tolerance = 1e-9;  ///< relative, per local step; with fixed steps: of Newton's method
  /// Absolute tolerance, scaled as in CvodesOptions.
  double absolute_tolerance = 1e-12;
  int fixed_steps = 0;      ///< equal steps per interval; 0: adaptive steps
  long max_steps = 100000;  ///< per interval
};
/// Deprecated name.
using ArkodeMethod [[deprecated("use ArkodeOptions::Method; removed in 0.4")]] =
    ArkodeOptions::Method;

/// Integrates the variational equations together with the state. Sensitivities are thus derivatives
/// of the steps taken. With the implicit method, they are accurate to the tolerance of Newton's
/// iteration, which shares one factorisation for state and sensitivities. With adaptive steps,
/// value() and jacobian() may take different steps, as with cvodes(). With fixed steps, they take
/// the same. There are no second derivatives. Throws DefinitionError for an order that does not
/// exist and for tolerances outside (0, 1).
IntegratorChoice arkode(ArkodeOptions options = {});

// IDAS: variable-order multistep integration of implicit differential equations with forward
// sensitivities under error control. The reference for differential-algebraic phases.

/// Options of idas().
struct IdasOptions {
  double tolerance = 1e-9;  ///< relative, per local step
  /// Absolute tolerance, multiplied by the nominal magnitude of each state and by the guess of each
  /// algebraic state. For sensitivities see CvodesOptions.
  double absolute_tolerance = 1e-12;
  long max_steps = 100000;  ///< per interval
};

/// Applies BDF to x' = f(t, x, z, u, p), 0 = g(t, x, z, u, p) in scaled time, starting from a
/// consistent z. Running costs are additional states. Sensitivities are included in error control;
/// those of z are only part of the equations. Also integrates ordinary phases and intervals with
/// events, where z is eliminated from the field. As with cvodes(), there are no second derivatives
/// and no allocation after the first call of each kind. Throws DefinitionError for a tolerance
/// outside (0, 1) or an absolute one that is negative or infinite.
IntegratorChoice idas(IdasOptions options = {});

}  // namespace saltus
