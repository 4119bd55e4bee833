// What an explicit scheme of fixed steps consists of, for those who write it down elsewhere.
#pragma once

#include <optional>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

struct ExplicitSteps {
  ButcherTableau tableau;
  int steps = 1;  ///< per interval, of equal length
};

/// Empty for every other scheme.
std::optional<ExplicitSteps> explicit_steps(const IntegratorScheme& scheme);

}  // namespace saltus
