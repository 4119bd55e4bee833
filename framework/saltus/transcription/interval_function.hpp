// Wraps an integrator as a Function of its interval, with the sparsity implied by the dynamics.
#pragma once

#include <memory>

#include "saltus/model/function.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/ocp/cost_functions.hpp"

namespace saltus {

/// w = (x0 | c | p | t0 | h) -> (x(t0 + h) | q). The pattern is that of the exact flow: the
/// transitive closure of the pattern of the dynamics. A failed integration gives NaN. The function
/// shares the integrator and is not re-entrant. `scheme`, if given, creates integrators for other
/// threads.
///
/// `optional` lists running costs of `costs`, whose function is that of the integrator's problem.
/// Each adds an argument after h, 1 or 0, that switches the cost on or off in this interval.
/// Between calls they are switched off.
Function interval_function(std::shared_ptr<Integrator> integrator, IntegratorChoice scheme = {},
                           SelectiveStack costs = {}, std::vector<int> optional = {});

}  // namespace saltus
