// The implicit midpoint rule with a fixed number of equal steps. Order 2, for stiff dynamics and
// for oscillations without numerical growth or damping.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Options of implicit_midpoint().
struct ImplicitMidpointOptions {
  int steps = 1;  ///< equal steps per interval
};

/// A-stable and symmetric; preserves quadratic invariants. Newton's method solves X = x + step/2
/// f(X) in each step to rounding. First and second derivatives are those of this map, by the
/// implicit function theorem. A failed step gives IntegrationStatus::step_too_small. Does not
/// allocate after construction. Throws DefinitionError if steps < 1, and for intervals with events.
IntegratorChoice implicit_midpoint(ImplicitMidpointOptions options = {});

}  // namespace saltus
