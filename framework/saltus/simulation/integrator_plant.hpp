// A plant given by its dynamics: any formula or hybrid automaton, with any integrator.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "saltus/model/automaton.hpp"
#include "saltus/model/event_integrator.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/simulation/loop_plant.hpp"
#include "saltus/simulation/plant_clock.hpp"

namespace saltus {

/// x' = f(t, x, u, p) with constant u during each call of advance(). Systems with events record
/// them and keep their mode. If an input, a parameter or a disturbance moves a guard past the state
/// (a thermostat's set-point), its event occurs at once. Exceptions of formulas become a failure().
class IntegratorPlant final : public LoopPlant {
 public:
  /// Starts from `start` (nx) at `time` seconds. `parameters` (np) are those of the plant and may
  /// differ from those of the controller's model. Running costs and derivatives of `problem` are
  /// ignored. Throws DefinitionError for wrong sizes or a scheme that does not fit the problem.
  IntegratorPlant(IntervalProblem problem, const IntegratorChoice& scheme, VectorXd start,
                  VectorXd parameters = {}, double time = 0.0);

  double time() const override { return clock_.time(); }
  VectorXd state() const override { return state_; }
  int inputs() const override { return integrator_->problem().arguments.nu; }
  bool advance(const VectorRef& input, double length) override;
  std::string failure() const override { return failure_; }
  std::string mode() const override;
  std::vector<HybridEvent> take_events() override { return std::exchange(events_, {}); }
  void disturb(const VectorRef& change) override;
  std::string name() const override { return name_; }

  /// Sets the parameters (np) from now on.
  void set_parameters(const VectorRef& parameters);

 private:
  bool integrate(double length);
  IntegrationStatus evaluate(double length);

  std::unique_ptr<Integrator> integrator_;
  EventIntegrator* hybrid_ = nullptr;  // the same object if it supports modes
  std::string name_, failure_;
  PlantClock clock_;
  VectorXd state_, parameters_, w_, end_;
  int mode_ = -1;  // -1: determined by the state
  std::vector<HybridEvent> events_;
};

/// A plant for dynamics that are a callable of (t, x), (t, x, u) or (t, x, u, p).
template <int nx, int nu, int np = 0, class Dynamics>
IntegratorPlant make_plant(Dynamics dynamics, const IntegratorChoice& scheme, VectorXd start,
                           VectorXd parameters = {}) {
  static_assert(ReturnsRows<Dynamics, nx, nx, nu, np>,
                "the dynamics of a plant must return Vec<S, nx>, one row per state");
  IntervalProblem problem;
  problem.arguments = {nx, nu, np};
  problem.dynamics = make_function<nx, nu, np>(std::move(dynamics));
  return {std::move(problem), scheme, std::move(start), std::move(parameters)};
}

/// A plant with modes and events.
template <int nx, int nu, int np>
IntegratorPlant make_plant(const Automaton<nx, nu, np>& automaton, const IntegratorChoice& scheme,
                           VectorXd start, VectorXd parameters = {}) {
  IntervalProblem problem;
  problem.arguments = {nx, nu, np};
  problem.switching = automaton.system();
  if (!problem.switching.modes.empty()) problem.dynamics = problem.switching.modes.front().dynamics;
  return {std::move(problem), scheme, std::move(start), std::move(parameters)};
}

/// The nominal model: dynamics, parameters, events and start of the first phase of a problem.
/// Throws DefinitionError if the problem has no phase.
IntegratorPlant nominal_plant(const OptimalControlProblem& problem, const IntegratorChoice& scheme);

}  // namespace saltus
