#include "saltus/model/integrator.hpp"

#include <fmt/format.h>

#include <limits>

#include "saltus/core/error.hpp"
#include "saltus/core/limit_at_zero.hpp"

namespace saltus {
namespace {

constexpr int levels = 7;
// Relative to 1 + the largest entry. Extrapolation of a smooth function easily achieves it.
constexpr double inaccurate = 1e-6;

}  // namespace

DirectionalDerivative directional_derivative(Integrator& integrator, const VectorRef& w,
                                             const VectorRef& direction, double first_step) {
  const int size = integrator.arguments().size();
  if (w.size() != size || direction.size() != size)
    throw DefinitionError(
        fmt::format("directional derivative: the point has {} entries and the direction {}, "
                    "expected {}",
                    w.size(), direction.size(), size));
  DirectionalDerivative result;
  const auto fail = [&](std::string why) {
    result.value.setConstant(integrator.outputs(), std::numeric_limits<double>::quiet_NaN());
    result.message = std::move(why);
    return result;
  };
  VectorXd beside(size), end(integrator.outputs());
  MatrixXd jacobian(integrator.outputs(), size);
  LimitAtZero limit;
  double step = first_step, first = 0.0, last = 0.0;
  for (int level = 0; level < levels; ++level, step *= 0.5) {
    beside = w + step * direction;
    jacobian.setZero();
    const IntegrationStatus status = integrator.jacobian(beside.data(), end.data(), jacobian);
    if (status != IntegrationStatus::success)
      return fail(integrator.failure().empty() ? describe(status) : integrator.failure());
    const VectorXd slope = jacobian * direction;
    limit.add(slope);
    last = slope.cwiseAbs().maxCoeff();
    if (level == 0) first = last;
  }
  result.error = limit.error() / (1.0 + limit.value().cwiseAbs().maxCoeff());
  // The slope of a square root doubles with every second halving of the step.
  if (last > 2.0 * (1.0 + first))
    return fail(fmt::format(
        "the derivative grows without bound, from {:.3g} to {:.3g} as the step decreases from "
        "{:.3g} to {:.3g}: the trajectory grazes a guard in this direction",
        first, last, first_step, 2.0 * step));
  if (!(result.error <= inaccurate))
    return fail(
        fmt::format("the extrapolated derivatives agree only to {:.1g}: use a shorter first step",
                    result.error));
  result.value = limit.value();
  result.exists = true;
  return result;
}

}  // namespace saltus
