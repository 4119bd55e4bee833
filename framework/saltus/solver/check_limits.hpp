// Checks the limits that all solvers of nonlinear programs share.
#pragma once

namespace saltus {

/// Throws DefinitionError unless the tolerance is positive and finite, `max_iterations` (-) is not
/// negative, and `time_limit` (s) is finite and not negative.
void check_limits(double tolerance, int max_iterations, double time_limit);

}  // namespace saltus
