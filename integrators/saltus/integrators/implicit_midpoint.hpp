// The implicit midpoint rule with a fixed number of equal steps: order 2, for stiff dynamics and
// for oscillations that must neither grow nor decay.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// What integrates by the implicit midpoint rule.
struct ImplicitMidpointOptions {
  int steps = 1;  ///< equal steps per interval
};

/// Stable whatever the step where the dynamics are (A-stable); keeps quadratic invariants and is
/// its own inverse. Each step solves X = x + step/2 f(X) by Newton's method to rounding;
/// derivatives of first and second order are those of the map so defined, by the implicit function
/// theorem. A step for which that fails is IntegrationStatus::step_too_small. Nothing allocates
/// after construction. Throws DefinitionError if steps < 1, and for intervals with events inside.
IntegratorChoice implicit_midpoint(ImplicitMidpointOptions options = {});

}  // namespace saltus
