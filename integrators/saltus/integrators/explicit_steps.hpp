// What an explicit scheme of fixed steps consists of, for those who write it down elsewhere.
#pragma once

#include <optional>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

/// A chain of explicit steps over one interval.
struct ExplicitSteps {
  ButcherTableau tableau;  ///< of each step
  int steps = 1;           ///< per interval, of equal length
};

/// Empty for every other scheme.
std::optional<ExplicitSteps> explicit_steps(const IntegratorScheme& scheme);

}  // namespace saltus
