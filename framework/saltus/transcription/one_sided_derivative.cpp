#include "saltus/transcription/optimum_derivatives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "saltus/core/error.hpp"
#include "saltus/core/limit_at_zero.hpp"

namespace saltus {
namespace {

constexpr int levels = 5;
constexpr double of_interval = 0.05;  // first step as a part of the shortest interval
// Relative to 1 + the largest entry. A larger error means that something else changes within the
// first step.
constexpr double inaccurate = 1e-5;

double shortest_interval(const Grid& grid) {
  double shortest = infinity;
  for (int j = 0; j < grid.phases(); ++j)
    if (grid.nominal_length(j) > 0.0) shortest = std::min(shortest, grid.nominal_length(j));
  return std::isfinite(shortest) ? shortest : 1.0;
}

}  // namespace

OneSidedDerivative one_sided_derivative(MultipleShooting& shooting, Solver& solver,
                                        const Solution& solution,
                                        std::span<const EventRate> direction) {
  const Schedule present = shooting.data().schedule;
  OneSidedDerivative result;
  const auto fail = [&](std::string why) {
    shooting.set_schedule(present);
    result.cost = std::numeric_limits<double>::quiet_NaN();
    result.first_input.setConstant(shooting.problem().phases().front().sizes.nu, result.cost);
    result.message = std::move(why);
    return result;
  };
  double fastest = 0.0;
  for (const EventRate& e : direction) {
    if (!std::isfinite(present.time_of(e.event)))
      return fail(fmt::format("event '{}' lies beyond every horizon", e.event));
    fastest = std::max(fastest, std::abs(e.rate));
  }
  if (!(fastest > 0.0) || !std::isfinite(fastest))
    return fail("no event moves along this direction, or a rate is not finite");

  LimitAtZero limit;
  double d = of_interval * shortest_interval(shooting.grid()) / fastest;
  for (int level = 0; level < levels; ++level, d *= 0.5) {
    try {
      shooting.set_schedule(moved(present, direction, d));
    } catch (const DefinitionError& e) {
      return fail(fmt::format("the events cannot move in this direction: {}", e.what()));
    }
    const Solution beside = solve(shooting, solver, shooting.guess_from(solution.trajectory));
    if (!beside.ok()) return fail(fmt::format("at the distance {:.3g}: {}", d, beside.message));
    OptimumDerivatives derivatives(shooting, beside);
    const OptimumDerivatives::Derivative one = derivatives.wrt_events(direction);
    if (!one.reliable) return fail(fmt::format("at the distance {:.3g}: {}", d, one.message));
    VectorXd rates(1 + one.first_input.size());
    rates << one.cost, one.first_input;
    limit.add(rates);
  }
  shooting.set_schedule(present);
  result.cost = limit.value()[0];
  result.first_input = limit.value().tail(limit.value().size() - 1);
  result.error = limit.error() / (1.0 + limit.value().cwiseAbs().maxCoeff());
  if (!(result.error <= inaccurate))
    result.message = fmt::format(
        "the extrapolated derivatives agree only to {:.1g}: other constraints are active there",
        result.error);
  result.reliable = result.message.empty();
  return result;
}

}  // namespace saltus
