// Control of a motion with an end: every tick solves the remaining problem from the measured state
// to the same end. Completed phases are dropped. The active phase and the total time are shortened
// by the elapsed time.
//
//     ShrinkingHorizonController controller(
//         problem, remaining_controllers(problem, grid, [](MultipleShooting rest) {
//           return RecedingHorizonController(std::move(rest), {.period = 0.1});
//         }));
//
// For another solver use make_controller(problem, grid, choice, options) of
// any_real_time_solver.hpp.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"

namespace saltus {

/// Creates one controller per phase with which the remaining problem can start, each on the grid of
/// the whole problem. Throws DefinitionError if a remaining problem is not valid by itself: see
/// OptimalControlProblem::after().
std::vector<RecedingHorizonController> remaining_controllers(
    const OptimalControlProblem& problem, ShootingOptions options,
    const std::function<RecedingHorizonController(MultipleShooting)>& controller_of);
/// Deprecated name.
[[deprecated(
    "use remaining_controllers; removed in 0.4")]] inline std::vector<RecedingHorizonController>
rests_of(const OptimalControlProblem& problem, ShootingOptions options,
         const std::function<RecedingHorizonController(MultipleShooting)>& controller_of) {
  return remaining_controllers(problem, std::move(options), controller_of);
}

/// Controller of a problem that ends. In each phase another controller plans the remaining phases.
/// Ticks do not allocate if the solver does not, except the tick in which a phase begins: it takes
/// over the plan of the previous phases. After a move, tick() of the source object returns a
/// fallback with an empty input and its other members throw DefinitionError.
class ShrinkingHorizonController {
 public:
  /// rests[j] controls the problem after j phases. All have the same period.
  ShrinkingHorizonController(const OptimalControlProblem& problem,
                             std::vector<RecedingHorizonController> rests);

  /// Control period in seconds.
  double period() const { return present().period(); }
  /// Name of the solver of the ticks.
  std::string solver_name() const { return present().solver_name(); }
  /// Index of the active phase: the first one until enter() is called.
  int phase() const { return phase_; }
  double entered_at() const { return entered_; }  ///< entry time in seconds
  /// The active phase.
  const PhaseDefinition& definition() const;
  /// Adopts an existing plan of the whole problem. Allocates.
  void adopt_plan(const Trajectory& plan);
  /// Reports that the plant entered a later phase at time t. Allocates. Throws DefinitionError if
  /// there is no such phase or t is not finite.
  void enter(int phase, double t);

  /// Runs a tick like RecedingHorizonController::tick, with the state of the active phase.
  const ControlTick& tick(double t, const VectorRef& state) noexcept;
  /// End time in seconds of the active or a later phase in the plan of the last tick. Throws
  /// DefinitionError for any other phase.
  double end_of_phase(int phase) const;
  /// Transcription of the next tick.
  MultipleShooting& shooting() { return present().shooting(); }
  /// The plan of the last tick; its first phase is phase().
  Solution report() { return present().report(); }
  /// The problem that report() solves.
  const OptimalControlProblem& rest() const { return present().problem(); }
  /// The problem with all its phases, including completed ones.
  const OptimalControlProblem& whole() const;
  /// Parameters p of a phase of whole(): the data of its control. Throws DefinitionError if there
  /// is no such phase.
  VectorXd parameters_of(int phase);

 private:
  const RecedingHorizonController& present() const;
  RecedingHorizonController& present();

  std::vector<RecedingHorizonController> rests_;
  std::vector<Bounds> durations_;  // bounds of the phase durations, in seconds
  Bounds total_time_;              // bounds of the total time, in seconds
  double start_, entered_;         // start of the problem and of the active phase, in seconds
  int phase_ = 0;
  ControlTick moved_from_;  // tick of a controller that was moved from
};

}  // namespace saltus
