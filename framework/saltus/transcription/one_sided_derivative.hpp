// One-sided derivatives of an optimum at an event that coincides with a node or another event. The
// optimal cost has a kink there, and OptimumDerivatives reports NaN with the reason.
//
// The optimal cost is smooth on either side. With event times t_i + d rate_i,
//
//     dJ*/dd (0+) = lim dJ*/dd (d),   d -> 0 from above, (framework/design/switch_times.md)
//
// The derivatives at d, d/2, d/4, ..., each at an optimum computed there, are extrapolated to zero.
#pragma once

#include <span>
#include <string>

#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/optimum_derivatives.hpp"

namespace saltus {

/// One-sided derivative of an optimum along a direction.
struct OneSidedDerivative {
  double cost = 0.0;      ///< d J* / dd at d = 0+; NaN if unknown
  VectorXd first_input;   ///< derivative of the first input, in its own units
  double error = 0.0;     ///< estimate, relative to 1 + the largest entry
  bool reliable = false;  ///< true if the optimum is sufficiently regular
  std::string message;    ///< the reason if not reliable, else empty
};

/// Computes the derivative along a direction in which events move. `solution` is an optimum at the
/// current event times. `solver` solves nearby problems and needs a tolerance of 1e-9 or less. The
/// problem is unchanged on return. Throws DefinitionError if an event is not in the schedule.
/// Allocates.
OneSidedDerivative one_sided_derivative(MultipleShooting& shooting, Solver& solver,
                                        const Solution& solution,
                                        std::span<const EventRate> direction);

}  // namespace saltus
