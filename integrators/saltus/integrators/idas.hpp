// IDAS: variable-order multistep integration of implicit differential equations with forward
// sensitivities under error control. The reference for differential-algebraic phases.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// What integrates with IDAS.
struct IdasOptions {
  double tolerance = 1e-9;  ///< relative, on each local step
  /// Absolute, times the nominal magnitude of each state, and of each algebraic state the magnitude
  /// of its guess; sensitivities as in CvodesOptions.
  double absolute_tolerance = 1e-12;
  long max_steps = 100000;  ///< per interval
};

/// Backward differentiation formulas on x' = f(t, x, z, u, p), 0 = g(t, x, z, u, p) in scaled time,
/// from z that meet g; running costs are additional states. Sensitivities take part in the error
/// control, those of z in the equations only. Ordinary phases are taken as well, and intervals with
/// events, in which z is eliminated from the field. All else is as for cvodes(): no second
/// derivatives, no allocation after the first call of each kind. Throws DefinitionError for a
/// tolerance outside (0, 1) or a negative absolute one.
IntegratorChoice idas(IdasOptions options = {});

}  // namespace saltus
