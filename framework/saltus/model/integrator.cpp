#include "saltus/model/integrator.hpp"

#include <map>
#include <utility>

namespace saltus {

IntervalProblem::IntervalProblem() = default;
IntervalProblem::IntervalProblem(const IntervalProblem& other) = default;
IntervalProblem::IntervalProblem(IntervalProblem&& other) noexcept = default;
IntervalProblem& IntervalProblem::operator=(const IntervalProblem& other) = default;
IntervalProblem& IntervalProblem::operator=(IntervalProblem&& other) noexcept = default;
IntervalProblem::~IntervalProblem() = default;

IntervalProblem IntervalProblem::separate() const {
  IntervalProblem own = *this;
  std::map<const void*, Function> separated;  // one per body, so handles to it stay equal
  const auto replace = [&](Function& f) {
    if (!f) return;
    const auto [at, is_new] = separated.try_emplace(f.identity());
    if (is_new) at->second = f.separate();
    if (at->second) f = at->second;
  };
  replace(own.dynamics);
  replace(own.running_cost);
  replace(own.algebraic.dynamics);
  for (SwitchingSystem::Mode& mode : own.switching.modes) {
    replace(mode.dynamics);
    replace(mode.running_cost);
  }
  for (SwitchingSystem::Transition& event : own.switching.transitions) {
    replace(event.guard);
    replace(event.reset);
  }
  return own;
}

Integrator::Integrator(const IntervalProblem& problem)
    : problem_(problem.separate()),
      interval_arguments_{problem_.arguments.nx, problem_.coefficients(), problem_.arguments.np} {
  problem_.differentiate_parameter.resize(problem_.arguments.np, false);
}

IntegrationStatus Integrator::hessian(const double*, const double*, MatrixXd&, Curvature) {
  return IntegrationStatus::library_failure;  // callers check has_hessian() first
}

IntegrationStatus Integrator::derivatives(const double* w, const double* weights, double* end,
                                          MatrixXd& derivative, MatrixXd& second,
                                          Curvature curvature) {
  const IntegrationStatus status = jacobian(w, end, derivative);
  return status == IntegrationStatus::success ? hessian(w, weights, second, curvature) : status;
}

const char* describe(IntegrationStatus status) {
  switch (status) {
    case IntegrationStatus::success:
      return "the integration reached the end of the interval";
    case IntegrationStatus::not_finite:
      return "the right-hand side or the state became infinite or NaN";
    case IntegrationStatus::too_many_steps:
      return "the step limit was reached before the end of the interval";
    case IntegrationStatus::step_too_small:
      return "error control failed at the smallest step size";
    case IntegrationStatus::library_failure:
      return "the integration library reported a failure";
    case IntegrationStatus::grazing:
      return "the trajectory touches a guard without crossing it, where no derivative exists";
    case IntegrationStatus::ambiguous_start:
      return "the state is on a guard whose rate is zero, so the mode is undetermined";
    case IntegrationStatus::non_unique:
      return "both fields point away from the surface at the state: the trajectory is not "
             "unique";
    case IntegrationStatus::beyond_guard:
      return "the state is beyond a guard, where no mode is active";
    case IntegrationStatus::accumulation:
      return "events accumulate (Zeno) or exceed the limit";
    case IntegrationStatus::sliding_input:
      return "the trajectory slides on a guard that depends on an input that varies in the "
             "interval";
    case IntegrationStatus::backward:
      return "an interval with events cannot be integrated backward in time";
  }
  return "unknown integration status";
}

}  // namespace saltus
