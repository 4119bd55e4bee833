#include "saltus/integrators/simulate.hpp"

#include <fmt/format.h>

#include <limits>
#include <string>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

void expect_size(const char* what, Eigen::Index given, Eigen::Index expected) {
  if (given != expected)
    throw DefinitionError(
        fmt::format("a simulation needs {} of size {}, but was given {}.", what, expected, given));
}

}  // namespace

Simulation simulate(Integrator& integrator, const VectorRef& x0, const VectorRef& times,
                    const Eigen::Ref<const MatrixXd>& coefficients, const VectorRef& parameters) {
  const IntervalArguments index = integrator.arguments();
  const int nx = index.nx, nq = integrator.outputs() - nx;
  if (times.size() < 1) throw DefinitionError("a simulation needs at least one time.");
  const int intervals = static_cast<int>(times.size()) - 1;
  expect_size("a start state", x0.size(), nx);
  expect_size("parameters", parameters.size(), index.np);
  expect_size("input coefficients per interval", coefficients.rows(), index.nc);
  expect_size("one column of input coefficients per interval", coefficients.cols(), intervals);
  for (int k = 0; k < intervals; ++k)
    if (!(times[k] <= times[k + 1]))
      throw DefinitionError(
          fmt::format("the times of a simulation must not decrease, but time {} is {} after {}.",
                      k + 1, times[k + 1], times[k]));

  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  Simulation result;
  result.times = times;
  result.states = MatrixXd::Constant(nx, intervals + 1, unknown);
  result.costs = MatrixXd::Constant(nq, intervals + 1, unknown);
  result.states.col(0) = x0;
  result.costs.col(0).setZero();
  VectorXd w(index.size()), end(integrator.outputs());
  for (int k = 0; k < intervals; ++k) {
    w << result.states.col(k), coefficients.col(k), parameters, times[k], times[k + 1] - times[k];
    result.status = integrator.value(w.data(), end.data());
    if (result.status != IntegrationStatus::success) break;
    result.states.col(k + 1) = end.head(nx);
    result.costs.col(k + 1) = result.costs.col(k) + end.tail(nq);
    ++result.intervals;
  }
  return result;
}

}  // namespace saltus
