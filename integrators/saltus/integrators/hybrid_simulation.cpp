#include "saltus/integrators/simulate.hpp"

#include <limits>
#include <memory>

#include "saltus/core/error.hpp"
#include "saltus/integrators/simulation_arguments.hpp"

namespace saltus {
namespace {

int mode_named(const SwitchingSystem& system, const std::string& name) {
  if (name.empty()) return -1;
  const int mode = system.mode_index(name);
  if (mode < 0)
    throw DefinitionError("a hybrid simulation cannot start in mode '" + name +
                          "', which does not exist.");
  return mode;
}

}  // namespace

HybridSimulation simulate_hybrid(const IntegratorChoice& scheme, IntervalProblem problem,
                                 const VectorRef& x0, const VectorRef& times,
                                 const Eigen::Ref<const MatrixXd>& coefficients,
                                 const VectorRef& parameters, const std::string& start_mode) {
  if (problem.switching.empty())
    throw DefinitionError(
        "a hybrid simulation needs events; use simulate() for problems without events.");
  problem.differentiate_parameter.assign(problem.arguments.np, true);
  const std::unique_ptr<Integrator> made = scheme->make(problem);
  auto* integrator = dynamic_cast<EventIntegrator*>(made.get());
  if (integrator == nullptr) throw DefinitionError(scheme->name() + " does not handle events.");

  const IntervalArguments index = integrator->arguments();
  const int nx = index.nx, np = index.np, ny = integrator->outputs();
  const int intervals =
      checked_intervals("hybrid simulation", index, x0, times, coefficients, parameters);
  integrator->start_in(mode_named(problem.switching, start_mode));

  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  HybridSimulation result;
  result.times = times;
  result.states = MatrixXd::Constant(nx, intervals + 1, unknown);
  result.costs = MatrixXd::Constant(ny - nx, intervals + 1, unknown);
  result.states.col(0) = x0;
  result.costs.col(0).setZero();
  result.derivative = MatrixXd::Zero(ny, nx + np);
  result.derivative.topLeftCorner(nx, nx).setIdentity();
  integrator->record(&result.events);
  VectorXd w(index.size()), end(ny);
  MatrixXd step(ny, index.size());
  for (int k = 0; k < intervals; ++k) {
    const std::size_t first_event = result.events.size();
    w << result.states.col(k), coefficients.col(k), parameters, times[k], times[k + 1] - times[k];
    result.status = integrator->jacobian(w.data(), end.data(), step);
    const MatrixXd before = result.derivative.topRows(nx);
    for (std::size_t e = first_event; e < result.events.size(); ++e) {
      VectorXd& rates = result.events[e].time_derivative;
      VectorXd chained = before.transpose() * rates.segment(index.x(), nx);
      chained.tail(np) += rates.segment(index.p(), np);
      rates = std::move(chained);
    }
    if (result.status != IntegrationStatus::success) break;
    result.derivative.topRows(nx) = step.topLeftCorner(nx, nx) * before;
    result.derivative.bottomRows(ny - nx) += step.bottomLeftCorner(ny - nx, nx) * before;
    result.derivative.rightCols(np) += step.middleCols(index.p(), np);
    result.states.col(k + 1) = end.head(nx);
    result.costs.col(k + 1) = result.costs.col(k) + end.tail(ny - nx);
    ++result.intervals;
    if (w[index.h()] > 0.0) integrator->start_in(integrator->end_mode());
    result.end_mode = integrator->mode_name(integrator->end_mode());
  }
  const std::string failure = integrator->failure();
  result.message = result.status == IntegrationStatus::success
                       ? std::string("the simulation reached its end")
                   : failure.empty() ? std::string(describe(result.status))
                                     : failure;
  return result;
}

}  // namespace saltus
