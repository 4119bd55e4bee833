// Sampled motions of the simulations. A run by name writes and draws them.
#pragma once

#include <string>
#include <vector>

#include "problems/library/simulation_case.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus::library {

/// Integrates from x0 through all `times` with the parameters p. Ends early with a reason if the
/// integration fails. Throws DefinitionError if the scheme does not fit the problem.
Motion simulate_motion(const IntervalProblem& problem, const IntegratorChoice& scheme,
                       const VectorXd& x0, const VectorXd& times, const VectorXd& p = VectorXd());

/// n + 1 times in equal steps.
inline VectorXd even_times(double from, double to, int n) {
  return VectorXd::LinSpaced(n + 1, from, to);
}

}  // namespace saltus::library
