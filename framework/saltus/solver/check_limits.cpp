#include "saltus/solver/check_limits.hpp"

#include <fmt/format.h>

#include <cmath>

#include "saltus/core/error.hpp"

namespace saltus {

void check_limits(double tolerance, int max_iterations, double time_limit) {
  if (!(tolerance > 0.0 && std::isfinite(tolerance)))
    throw DefinitionError(
        fmt::format("solver: the tolerance is {}, expected a finite number above 0", tolerance));
  if (max_iterations < 0)
    throw DefinitionError(
        fmt::format("solver: max_iterations is {}, expected at least 0", max_iterations));
  if (!(time_limit >= 0.0 && std::isfinite(time_limit)))
    throw DefinitionError(fmt::format(
        "solver: the time limit is {} s, expected a finite number, or 0 for none", time_limit));
}

}  // namespace saltus
