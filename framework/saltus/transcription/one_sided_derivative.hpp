// One-sided derivatives of an optimum where it has no other: an event at a node or at another
// event. There the optimal cost bends, and OptimumDerivatives says NaN and why.
//
// Beside that instant all is smooth. With t_i + d rate_i for the events,
//
//     dJ*/dd (0+) = lim dJ*/dd (d),   d -> 0 from above, (framework/design/switch_times.md)
//
// and the derivatives at d, d/2, d/4, ..., each at an optimum found there, are extrapolated to
// zero.
#pragma once

#include <span>
#include <string>

#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/optimum_derivatives.hpp"

namespace saltus {

/// Of the optimum, as a parameter grows or falls.
struct OneSidedDerivative {
  double cost = 0.0;      ///< d J* / dd at d = 0+; NaN where it is not known
  VectorXd first_input;   ///< of the input applied at the start, in its own units
  double error = 0.0;     ///< estimated, relative to 1 + the largest entry
  bool reliable = false;  ///< whether the optimum was regular enough
  std::string message;    ///< why not; empty if reliable
};

/// Along a direction in which events move. `solver` solves the problem beside the present instant,
/// to a tolerance of 1e-9 or less, from `solution`, which is an optimum at it. The problem stands
/// as before when it returns. Throws DefinitionError if an event is not in the schedule. Allocates.
OneSidedDerivative one_sided_derivative(MultipleShooting& shooting, Solver& solver,
                                        const Solution& solution,
                                        std::span<const EventRate> direction);

}  // namespace saltus
