// Intervals with the algebraic states z as states with "rates" g, for DAE integrators.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// The interval over (x z) instead of x, with rates (f | g) and first derivatives only. Returns the
/// problem itself if it has no algebraic part. Omits nominal states.
IntervalProblem with_algebraic_states(const IntervalProblem& problem);

}  // namespace saltus
