#include "saltus/model/steps_of.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"

namespace saltus {

FormulaSteps steps_of(const Function& function) {
  if (function.steps() == nullptr)
    throw DefinitionError("the function is composed of other functions, not made from a formula");
  const FormulaSteps& steps = *function.steps();
  check_steps(steps, function, VectorXd::Constant(function.inputs(), 0.5), "a formula");
  return steps;
}

void check_steps(const FormulaSteps& steps, const Function& function, const VectorXd& z,
                 const char* what, int points) {
  // Relative rounding error of a few thousand operations in a different order.
  constexpr double rounding = 1e-9;
  constexpr double radius = 1e-3;  // relative; small for steep formulas (density over altitude)
  Random random(1);
  VectorXd at = z;
  for (int k = 0; k < points; ++k) {
    const VectorXd expected = function(at);
    const std::vector<double> found =
        steps.evaluate(std::span<const double>(at.data(), static_cast<std::size_t>(at.size())));
    for (int i = 0; i < expected.size() && expected.allFinite(); ++i)
      if (!(std::abs(found[i] - expected[i]) <= rounding * (1.0 + std::abs(expected[i]))))
        throw DefinitionError(
            fmt::format("{}: output {} of its steps is {}, but the function returns {}", what, i,
                        found[i], expected[i]));
    for (int i = 0; i < at.size(); ++i) at[i] = z[i] * (1.0 + radius * random.uniform(-1.0, 1.0));
  }
}

}  // namespace saltus
