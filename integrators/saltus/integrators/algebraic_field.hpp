// Intervals with z as states whose "rates" are g, for integrators of differential-algebraic
// equations.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// The interval over (x z) in place of x, with rates (f | g), first derivatives only; itself
/// without an algebraic part. Typical magnitudes of states are left out.
IntervalProblem with_algebraic_states(const IntervalProblem& problem);

}  // namespace saltus
