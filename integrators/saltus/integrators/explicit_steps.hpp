// Tableau and steps of an explicit fixed-step scheme, for exporters.
#pragma once

#include <optional>
#include <string>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

/// Explicit steps over one interval.
struct ExplicitSteps {
  ButcherTableau tableau;  ///< tableau of each step
  int steps = 1;           ///< per interval, of equal length
};

/// Throws DefinitionError with the name of the scheme if the steps per interval are not within 1
/// and 1,000,000.
void check_steps(const std::string& scheme, int steps);

/// The steps of an explicit scheme. Empty for every other scheme.
std::optional<ExplicitSteps> explicit_steps(const IntegratorScheme& scheme);

}  // namespace saltus
