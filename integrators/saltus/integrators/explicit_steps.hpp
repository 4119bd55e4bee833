// Tableau and steps of an explicit fixed-step scheme, for exporters.
#pragma once

#include <optional>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

/// Explicit steps over one interval.
struct ExplicitSteps {
  ButcherTableau tableau;  ///< tableau of each step
  int steps = 1;           ///< per interval, of equal length
};

/// The steps of an explicit scheme. Empty for every other scheme.
std::optional<ExplicitSteps> explicit_steps(const IntegratorScheme& scheme);

}  // namespace saltus
