// The plant of a problem with phases: their dynamics one after the other, with the jumps between
// them. A phase ends where its guard passes zero, or else when it is told to: the instant of a
// switch is then an input like others. What the motion costs, and how far it misses what the
// problem asks for, is counted along the way.
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

/// A plant that goes through the phases of a problem.
class PhasedPlant final : public LoopPlant {
 public:
  /// Begins at the problem's start (its guess, where it is free). Unknown parameters keep their
  /// guesses. Throws DefinitionError when the scheme does not fit a phase, or a phase has events
  /// inside: IntegratorPlant is for those.
  PhasedPlant(OptimalControlProblem problem, const IntegratorChoice& scheme);

  double time() const override { return clock_.time(); }
  VectorXd state() const override { return state_; }
  /// Of the present phase.
  int inputs() const override { return definition().sizes.nu; }
  /// A guard is looked at where the piece ends: one that is crossed twice within it is not noticed.
  /// A phase that begins on it or beyond it ends at once, or comes back first.
  /// Once the last phase has ended time goes on, and nothing else. An input of another phase's size
  /// is cut off or filled up by zeros, any other size throws DefinitionError.
  bool advance(const VectorRef& input, double length) override;
  std::string failure() const override { return failure_; }
  std::string mode() const override { return definition().name; }
  std::vector<HybridEvent> take_events() override { return std::exchange(events_, {}); }
  void disturb(const VectorRef& change) override;
  std::string name() const override { return name_; }

  /// As it was given.
  const OptimalControlProblem& problem() const { return problem_; }
  /// Parameters p of a phase.
  const VectorXd& parameters_of(int phase) const { return phases_[phase].parameters; }
  /// How many.
  int phases() const { return static_cast<int>(problem_.phases().size()); }
  /// That is in force.
  int phase() const { return phase_; }
  double entered_at() const { return entered_; }  ///< the present phase, s
  /// When a phase that is not over will end, s; not heard where a guard decides. Until told, never.
  void end_phase_at(int phase, double t) { ends_[phase] = t; }
  /// When the last phase, in which the plant is, will end as told, s; infinity before, where a
  /// guard decides, and until told.
  double end() const;
  /// Whether the last phase has ended.
  bool is_over() const { return over_since_.has_value(); }
  double over_since() const { return *over_since_; }  ///< s; once it is over

  /// Of the motion so far: running costs integrated, whatever rule the problem sums them by, and
  /// terms at the phases' starts and ends. Penalties and costs of changes are not in it.
  double cost() const { return cost_; }
  /// Something that is asked for and missed, in its own units.
  struct Miss {
    std::string phase, term;  ///< where and what
    double time = 0.0;        ///< s
    double amount = 0.0;      ///< beyond its bound, in the term's unit
  };
  /// The largest of each hard term and bounded state at ends of phases (and their starts), or along
  /// the motion, where pieces end.
  const std::vector<Miss>& misses_at_ends() const { return at_ends_; }
  /// Of path constraints.
  const std::vector<Miss>& misses_on_the_way() const { return on_the_way_; }

 private:
  struct Phase {
    std::unique_ptr<Integrator> integrator;
    std::vector<int> running;  // terms: the integrator's costs
    SelectiveStack costs;      // these
    VectorXd parameters;
  };
  const PhaseDefinition& definition() const { return problem_.phases()[phase_]; }
  VectorXd fitted(const VectorRef& input) const;
  VectorXd argument(const VectorRef& input) const;
  IntegrationStatus integrate(const VectorRef& input, double length);
  bool advance_from_here(const VectorRef& input, double length);
  std::optional<double> move(const VectorRef& input, double length);
  double guard(const VectorRef& input) const;   // oriented: negative inside the phase
  double growth(const VectorRef& input) const;  // of the guard, per s
  bool is_leaving(const VectorRef& input) const;
  void end_phase(const VectorRef& input);
  void begin_phase(const VectorRef& input);
  bool is_in_force(const Window& window, double t) const;
  void count_once(TermDomain domain, const VectorRef& input);
  void look_on_the_way(const VectorRef& input);

  OptimalControlProblem problem_;
  std::vector<Phase> phases_;
  std::vector<double> ends_;  // s
  std::string name_, failure_;
  int phase_ = 0;
  PlantClock clock_;
  double entered_;
  VectorXd state_, end_;
  std::optional<double> over_since_;
  double cost_ = 0.0;
  bool has_begun_ = false;
  bool passed_guard_ = false;  // at the start or by a push: the phase ends with the next piece
  std::vector<Miss> at_ends_, on_the_way_;
  std::vector<HybridEvent> events_;
};

}  // namespace saltus
