// Plants for closed loops: the interface, a plant of an integrator, and the phases of a problem as
// a plant.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/model/automaton.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/ocp/cost_functions.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/ocp/pulse.hpp"

namespace saltus {

// Time of a plant: its start plus the sum of its steps. Far from zero, where adjacent doubles are
// 1e-7 s apart, steps shorter than that still count.

/// Time of a plant in seconds, as the Kahan sum of its steps. Its error does not grow with their
/// number.
class PlantClock {
 public:
  /// Starts at `start` seconds.
  explicit PlantClock(double start) : start_(start) {}

  /// Current time in seconds.
  double time() const { return start_ + elapsed_; }
  /// Advances by `length` seconds.
  void move_on(double length) {
    const double added = length + missing_, sum = elapsed_ + added;
    missing_ = added - (sum - elapsed_);
    elapsed_ = sum;
  }

 private:
  double start_, elapsed_ = 0.0;
  double missing_ = 0.0;  // rounding error of elapsed_
};

// Interface of plants in a closed loop.

/// Derive from this class to use your own simulator; four functions are required. For dynamics
/// given as formulas use IntegratorPlant.
class LoopPlant {
 public:
  virtual ~LoopPlant() = default;

  virtual double time() const = 0;     ///< current time in seconds
  virtual VectorXd state() const = 0;  ///< true state (nx); the controller measures it with noise
  virtual int inputs() const = 0;      ///< number of inputs, nu
  /// Advances by `length` >= 0 seconds under a constant input (nu). On failure returns false,
  /// leaves time() and state() unchanged, and failure() explains the reason in a sentence.
  virtual bool advance(const VectorRef& input, double length) = 0;

  /// Reason why advance() failed.
  virtual std::string failure() const { return "the plant could not advance"; }
  /// Name of the active mode; empty if the plant has only one.
  virtual std::string mode() const { return {}; }
  /// Events since the last call, in order of time.
  virtual std::vector<HybridEvent> take_events() { return {}; }
  /// Called when the problem of a ShrinkingHorizonController enters this phase. Make the jump of
  /// the state here if the plant does not make it by itself.
  virtual void enter_phase(int /*phase*/) {}
  /// Adds `change` (nx) to the state. Throws DefinitionError if the plant does not support it.
  virtual void disturb(const VectorRef& change);
  /// Receives the pulses of the loop before the first tick. A plant that applies them as forces
  /// while it advances keeps a copy and returns true. Otherwise the loop adds their impulses to the
  /// state by disturb().
  virtual bool take_pulses(std::span<const Pulse> /*pulses*/) { return false; }
  /// Name of the plant in messages and results.
  virtual std::string name() const { return "plant"; }
};

/// Error sentence of advance() for a negative or non-finite length.
std::string describe_bad_length(double length);

// A plant given by its dynamics: any formula or hybrid automaton, with any integrator.

/// Plant that integrates x' = f(t, x, u, p) with any integrator, with constant u during each call
/// of advance(). Systems with events record them and keep their mode. If an input, a parameter or a
/// disturbance moves a guard past the state (a thermostat's set-point), its event occurs at once.
/// Exceptions of formulas become a failure(). After a move, inputs(), advance() and mode() of the
/// source object throw DefinitionError.
class IntegratorPlant final : public LoopPlant {
 public:
  /// Starts from `start` (nx) at `time` seconds. `parameters` (np) are those of the plant and may
  /// differ from those of the controller's model. Running costs and derivatives of `problem` are
  /// ignored. Throws DefinitionError for wrong sizes or a scheme that does not fit the problem.
  IntegratorPlant(IntervalProblem problem, const IntegratorChoice& scheme, VectorXd start,
                  VectorXd parameters = {}, double time = 0.0);

  double time() const override { return clock_.time(); }
  VectorXd state() const override { return state_; }
  int inputs() const override { return integrator().problem().arguments.nu; }
  bool advance(const VectorRef& input, double length) override;
  std::string failure() const override { return failure_; }
  std::string mode() const override;
  std::vector<HybridEvent> take_events() override { return std::exchange(events_, {}); }
  void disturb(const VectorRef& change) override;
  std::string name() const override { return name_; }

  /// Sets the parameters (np) from now on.
  void set_parameters(const VectorRef& parameters);

 private:
  Integrator& integrator() const;
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

// The plant of a problem with phases: it integrates their dynamics in order, with the jumps between
// them. A phase ends where its guard crosses zero, or otherwise at a given time; a switch time is
// then an input like any other. The plant integrates the cost of the motion and records violations
// of the problem's constraints.

/// A plant that runs through the phases of a problem. Members that take or need a phase throw
/// DefinitionError if there is none, as after a move.
class PhasedPlant final : public LoopPlant {
 public:
  /// Starts at the start of the problem (its guess, if free). Unknowns keep their guesses.
  /// Throws DefinitionError if the scheme does not fit a phase or a phase has inner events; use
  /// IntegratorPlant for those.
  PhasedPlant(OptimalControlProblem problem, const IntegratorChoice& scheme);

  double time() const override { return clock_.time(); }
  VectorXd state() const override { return state_; }
  /// Number of inputs of the active phase.
  int inputs() const override { return definition().sizes.nu; }
  /// The guard is checked at the end of each piece; two crossings within a piece are missed. A
  /// phase that starts on its guard or beyond it ends at once, or returns first. After the last
  /// phase only time advances. An input of the size of another phase is truncated or padded by
  /// zeros; any other size throws DefinitionError.
  bool advance(const VectorRef& input, double length) override;
  std::string failure() const override { return failure_; }
  std::string mode() const override { return definition().name; }
  std::vector<HybridEvent> take_events() override { return std::exchange(events_, {}); }
  void disturb(const VectorRef& change) override;
  std::string name() const override { return name_; }

  /// The problem as given.
  const OptimalControlProblem& problem() const { return problem_; }
  /// Parameters p of a phase.
  const VectorXd& parameters_of(int phase) const { return phases_[checked(phase)].parameters; }
  /// Number of phases.
  int phases() const { return static_cast<int>(problem_.phases().size()); }
  /// Index of the active phase.
  int phase() const { return phase_; }
  double entered_at() const { return entered_; }  ///< start of the active phase in seconds
  /// Sets the end time in seconds of the active or a later phase. Phases with a guard ignore it.
  /// Throws DefinitionError for a phase that does not exist and for NaN.
  /// The default is never.
  void end_phase_at(int phase, double t);
  /// End time in seconds of the last phase once the plant is in it. Infinite until then, until it
  /// is set, and if a guard ends the phase.
  double end() const;
  /// True if the last phase has ended.
  bool is_over() const { return over_since_.has_value(); }
  /// Time in seconds at which the last phase ended. Throws DefinitionError before it has ended.
  double over_since() const;

  /// Cost of the motion so far: integrals of running costs, regardless of the cost rule, and terms
  /// at starts and ends of phases. Without penalties and costs of input changes.
  double cost() const { return cost_; }
  /// A violated constraint, in its own units.
  struct Miss {
    std::string phase, term;  ///< names of phase and term
    double time = 0.0;        ///< time in seconds
    double amount = 0.0;      ///< violation of its bound, in the unit of the term
  };
  /// Largest violation of each hard term and bounded state at starts and ends of phases.
  const std::vector<Miss>& end_misses() const { return at_ends_; }
  /// Deprecated name.
  [[deprecated("use end_misses; removed in 0.4")]] const std::vector<Miss>& misses_at_ends() const {
    return at_ends_;
  }
  /// Largest violation of each path constraint, sampled at the ends of pieces.
  const std::vector<Miss>& path_misses() const { return on_the_way_; }
  /// Deprecated name.
  [[deprecated("use path_misses; removed in 0.4")]] const std::vector<Miss>& misses_on_the_way()
      const {
    return on_the_way_;
  }

 private:
  struct Phase {
    std::unique_ptr<Integrator> integrator;
    std::vector<int> running;  // terms of the integrator's costs
    SelectiveStack costs;      // functions of these terms
    VectorXd parameters;
  };
  std::size_t checked(int phase) const;
  const PhaseDefinition& definition() const { return problem_.phases()[checked(phase_)]; }
  VectorXd fitted(const VectorRef& input) const;
  VectorXd argument(const VectorRef& input) const;
  IntegrationStatus integrate(const VectorRef& input, double length);
  bool advance_from_here(const VectorRef& input, double length);
  std::optional<double> move(const VectorRef& input, double length);
  double guard(const VectorRef& input) const;   // oriented: negative inside the phase
  double growth(const VectorRef& input) const;  // rate of the guard per second
  bool is_leaving(const VectorRef& input) const;
  void end_phase(const VectorRef& input);
  void begin_phase(const VectorRef& input);
  bool is_in_force(const Window& window, double t) const;
  void count_once(Term::Domain domain, const VectorRef& input);
  void check_path_constraints(const VectorRef& input);

  OptimalControlProblem problem_;
  std::vector<Phase> phases_;
  std::vector<double> ends_;  // in seconds
  std::string name_, failure_;
  int phase_ = 0;
  PlantClock clock_;
  double entered_;
  VectorXd state_, end_;
  std::optional<double> over_since_;
  double cost_ = 0.0;
  bool has_begun_ = false;
  // true at the start or after a disturbance: the phase ends with the next piece
  bool passed_guard_ = false;
  std::vector<Miss> at_ends_, on_the_way_;
  std::vector<HybridEvent> events_;
};

}  // namespace saltus
