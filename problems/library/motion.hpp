// The motions of the simulations, sampled: what is written and drawn when one is run by name.
#pragma once

#include <string>
#include <vector>

#include "problems/library/simulation_case.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus::library {

/// From x0 through all `times`, with the parameters p. Ends early, and says why, where the
/// integration fails. Throws DefinitionError when the scheme does not fit the problem.
Motion simulate_motion(const IntervalProblem& problem, const IntegratorChoice& scheme,
                       const VectorXd& x0, const VectorXd& times, const VectorXd& p = VectorXd());

/// n + 1 times in equal steps.
inline VectorXd even_times(double from, double to, int n) {
  return VectorXd::LinSpaced(n + 1, from, to);
}

}  // namespace saltus::library
