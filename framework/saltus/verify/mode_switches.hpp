// State-triggered events inside an interval, for the verifier: the mode at its start, and the time
// at which a step crosses a guard. Conventions: framework/design/events.md.
#pragma once

#include <optional>
#include <vector>

#include "saltus/ocp/phase_definition.hpp"
#include "saltus/verify/controlled_steps.hpp"

namespace saltus {

/// Modes of a phase along an interval. Cases that it cannot decide (sliding on a surface, a start
/// on a guard without a rate) are reported.
class ModeSwitches {
 public:
  explicit ModeSwitches(const PhaseDefinition& phase) : phase_(phase) {}

  bool empty() const { return phase_.switching.empty(); }
  /// Finds the mode at s = 0 and sets its dynamics in `field`. Returns false if undecided.
  bool start(PlanField& field, const VectorXd& state);
  /// Fraction of the last step at which a guard of the mode is first crossed; empty: none is
  /// crossed.
  std::optional<double> first_event(PlanField& field, const ControlledSteps& steps);
  /// Applies the event at scaled time s: `y` becomes the state after it. Returns false if
  /// undecided.
  bool take(PlanField& field, double s, std::vector<double>& y);

 private:
  double guard(const SwitchingSystem::Transition& t, PlanField& field, double s, const double* x);
  double guard_rate(const SwitchingSystem::Transition& t, PlanField& field, double s,
                    const double* x, double& size);
  const SwitchingSystem& system() const { return phase_.switching; }

  const PhaseDefinition& phase_;
  int mode_ = 0, transition_ = -1;
  std::vector<double> x_;
};

}  // namespace saltus
