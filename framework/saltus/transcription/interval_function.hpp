// An integrator as a Function of its interval, with the sparsity that the dynamics imply.
#pragma once

#include <memory>

#include "saltus/model/function.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/ocp/cost_functions.hpp"

namespace saltus {

/// w = (x0 | c | p | t0 | h) -> (x(t0 + h) | q). The pattern is that of the exact flow: the
/// transitive closure of the dynamics' own. A failed integration yields NaN. Shares the integrator
/// and is not re-entrant; `scheme`, if given, makes others like it for other threads.
///
/// `optional` lists running costs of `costs`, whose function is that of the integrator's problem.
/// They are arguments behind h, 1 or 0: whether the cost is evaluated in this interval. Between
/// calls they are left out.
Function interval_function(std::shared_ptr<Integrator> integrator, IntegratorChoice scheme = {},
                           SelectiveStack costs = {}, std::vector<int> optional = {});

}  // namespace saltus
