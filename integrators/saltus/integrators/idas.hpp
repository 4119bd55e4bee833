// IDAS: variable-order multistep integration of implicit differential equations with forward
// sensitivities under error control. The reference for differential-algebraic phases.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

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
/// outside (0, 1) or a negative absolute one.
IntegratorChoice idas(IdasOptions options = {});

}  // namespace saltus
