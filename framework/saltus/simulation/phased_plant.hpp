// The plant of a problem with phases: it integrates their dynamics in order, with the jumps between
// them. A phase ends where its guard crosses zero, or otherwise at a given time; a switch time is
// then an input like others. The plant integrates the cost of the motion and records violations of
// the problem's constraints.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "saltus/model/integrator.hpp"
#include "saltus/ocp/cost_functions.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/simulation/loop_plant.hpp"
#include "saltus/simulation/plant_clock.hpp"

namespace saltus {

/// A plant that runs through the phases of a problem.
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
  const VectorXd& parameters_of(int phase) const { return phases_[phase].parameters; }
  /// Number of phases.
  int phases() const { return static_cast<int>(problem_.phases().size()); }
  /// Index of the active phase.
  int phase() const { return phase_; }
  double entered_at() const { return entered_; }  ///< start of the active phase in seconds
  /// Sets the end time in seconds of the active or a later phase. Phases with a guard ignore it.
  /// The default is never.
  void end_phase_at(int phase, double t) { ends_[phase] = t; }
  /// End time in seconds of the last phase once the plant is in it. Infinite before, with a guard,
  /// and until set.
  double end() const;
  /// True if the last phase has ended.
  bool is_over() const { return over_since_.has_value(); }
  double over_since() const { return *over_since_; }  ///< in seconds; only valid once it is over

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
  const std::vector<Miss>& misses_at_ends() const { return at_ends_; }
  /// Largest violation of each path constraint, sampled at the ends of pieces.
  const std::vector<Miss>& misses_on_the_way() const { return on_the_way_; }

 private:
  struct Phase {
    std::unique_ptr<Integrator> integrator;
    std::vector<int> running;  // terms of the integrator's costs
    SelectiveStack costs;      // functions of these terms
    VectorXd parameters;
  };
  const PhaseDefinition& definition() const { return problem_.phases()[phase_]; }
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
  void count_once(TermDomain domain, const VectorRef& input);
  void look_on_the_way(const VectorRef& input);

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
