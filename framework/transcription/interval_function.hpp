// An integrator as a Function of its interval, with the sparsity that the dynamics imply.
#pragma once

#include <memory>

#include "saltus/model/function.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus {

/// w = (x0 | c | p | t0 | h) -> (x(t0 + h) | q). The pattern is that of the exact flow: the
/// transitive closure of the dynamics' own. A failed integration yields NaN. Shares the integrator
/// and is not re-entrant; `scheme`, if given, makes others like it for other threads.
Function interval_function(std::shared_ptr<Integrator> integrator, IntegratorChoice scheme = {});

}  // namespace saltus
