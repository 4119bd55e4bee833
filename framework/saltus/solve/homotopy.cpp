#include "saltus/solve/solve.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/core/error.hpp"

namespace saltus {

Homotopy solve_along(MultipleShooting& shooting, Solver& solver, std::string_view name,
                     const VectorRef& from, const VectorRef& to, const HomotopyOptions& options) {
  if (from.size() != to.size())
    throw DefinitionError(
        fmt::format("solve_along: '{}' has {} entries at the start and {} at the end", name,
                    from.size(), to.size()));
  if (!(options.first_step > 0.0 && options.first_step <= 1.0 && options.least_step > 0.0))
    throw DefinitionError(
        fmt::format("solve_along: the first step is {} and the least {}; expected fractions of the "
                    "path above 0",
                    options.first_step, options.least_step));
  const auto value_at = [&](double s) -> VectorXd { return (1.0 - s) * from + s * to; };
  // Intermediate solutions need only be optima of their grid; the last one must be a full solution.
  const auto is_solved = [](const Solution& solution) {
    return solution.ok() || solution.status == SolveStatus::coarse_grid;
  };
  Homotopy result;
  shooting.set_data(name, value_at(0.0));
  result.solution = solve(shooting, solver);
  result.steps.push_back(
      {0.0, result.solution.cost, is_solved(result.solution), result.solution.iterations});
  double step = options.first_step;
  while (is_solved(result.solution) && result.reached < 1.0 && step >= options.least_step) {
    const double at = std::min(1.0, result.reached + step);
    shooting.set_data(name, value_at(at));
    Solution next = solve(shooting, solver, result.solution.point);
    result.steps.push_back({at, next.cost, is_solved(next), next.iterations});
    if (is_solved(next)) {
      result.solution = std::move(next);
      result.reached = at;
      step *= 2.0;
    } else {
      // half of the last attempt, which may be shorter than `step`
      step = 0.5 * (at - result.reached);
    }
  }
  shooting.set_data(name, value_at(result.reached));
  return result;
}

}  // namespace saltus
