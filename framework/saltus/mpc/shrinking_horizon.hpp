// Control of a motion that has an end: every tick solves what is left of the problem, from the
// measured state to the same end. Phases that are over are dropped; the one that has begun, and the
// total time, lose what has passed.
//
//     ShrinkingHorizonController controller(
//         problem, rests_of(problem, grid, [](MultipleShooting rest) {
//           return RecedingHorizonController(std::move(rest), {.period = 0.1});
//         }));
//
// (by a solver of choice: make_controller(problem, grid, choice, options) in
// any_real_time_solver.hpp).
#pragma once

#include <functional>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"

namespace saltus {

/// A controller for every phase with which what is left can begin, each on the grid that the phases
/// have in all. Throws DefinitionError when a rest is no problem of its own: see
/// OptimalControlProblem::after().
std::vector<RecedingHorizonController> rests_of(
    const OptimalControlProblem& problem, ShootingOptions options,
    const std::function<RecedingHorizonController(MultipleShooting)>& controller_of);

/// Ticks allocate nothing if the solver does not, but for the one in which a phase begins: it takes
/// over the plan of those before it. One that was moved from throws DefinitionError, except tick():
/// that is a fallback with an empty input.
class ShrinkingHorizonController {
 public:
  /// rests[j]: of the problem after j phases. All have one period.
  ShrinkingHorizonController(const OptimalControlProblem& problem,
                             std::vector<RecedingHorizonController> rests);

  /// Of the ticks, s.
  double period() const { return present().period(); }
  /// Of what solves the ticks.
  std::string solver_name() const { return present().solver_name(); }
  /// The phase that ticks take to have begun: the first one until said otherwise.
  int phase() const { return phase_; }
  double entered_at() const { return entered_; }  ///< s
  /// The phase that is in force.
  const PhaseDefinition& definition() const;
  /// Begins with a plan of the whole problem, made ahead. Allocates.
  void adopt_plan(const Trajectory& plan);
  /// The plant went on to a later phase at time t. Allocates. Throws DefinitionError unless there
  /// is such a phase and t is finite.
  void enter(int phase, double t);

  /// As RecedingHorizonController::tick, with the state of the present phase.
  const ControlTick& tick(double t, const VectorRef& state) noexcept;
  /// When the plan behind the last tick's input ends a phase that is not over, s. Throws
  /// DefinitionError for any other phase.
  double end_of_phase(int phase) const;
  /// What the next tick solves.
  MultipleShooting& shooting() { return present().shooting(); }
  /// The plan behind the last tick's input; its first phase is phase().
  Solution report() { return present().report(); }
  /// What report() is a solution of.
  const OptimalControlProblem& rest() const { return present().problem(); }
  /// The problem with all its phases, whichever of them are over.
  const OptimalControlProblem& whole() const;
  /// Parameters p of a phase of whole(): the data with which it is, or was, controlled.
  VectorXd parameters_of(int phase);

 private:
  const RecedingHorizonController& present() const;
  RecedingHorizonController& present();

  std::vector<RecedingHorizonController> rests_;
  std::vector<Bounds> durations_;  // of the phases, s
  Bounds total_time_;              // s
  double start_, entered_;         // of the problem, and of the present phase, s
  int phase_ = 0;
  ControlTick moved_from_;  // the answer of a controller that has no rests any more
};

}  // namespace saltus
