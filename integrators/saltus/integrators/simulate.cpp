#include "saltus/integrators/simulate.hpp"

#include <limits>

#include "saltus/integrators/simulation_arguments.hpp"

namespace saltus {
Simulation simulate(Integrator& integrator, const VectorRef& x0, const VectorRef& times,
                    const Eigen::Ref<const MatrixXd>& coefficients, const VectorRef& parameters) {
  const IntervalArguments index = integrator.arguments();
  const int nx = index.nx, nq = integrator.outputs() - nx;
  const int intervals = checked_intervals("simulation", index, x0, times, coefficients, parameters);

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
