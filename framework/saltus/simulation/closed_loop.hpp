// A closed loop in simulation: every period the controller sees the plant's state, through noise
// and delay, and the plant moves on under the controller's input, with what disturbs it.
//
//     RecedingHorizonController controller(MultipleShooting(problem, grid), solver, {.period =
//     0.1}); IntegratorPlant plant = nominal_plant(problem, cvodes()); const LoopLog log =
//     simulate_closed_loop(controller, plant, {.duration = 5.0}); log.write("results/car");
#pragma once

#include <concepts>
#include <functional>
#include <string>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/mpc/shrinking_horizon.hpp"
#include "saltus/simulation/disturbances.hpp"
#include "saltus/simulation/integrator_plant.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/simulation/loop_plant.hpp"
#include "saltus/simulation/phased_plant.hpp"

namespace saltus {

/// How a closed loop is run and recorded.
struct LoopOptions {
  double duration = 1.0;     ///< s; the last tick may end a little later
  double period = 0.01;      ///< of a feedback law, s; a receding horizon controller has its own
  int samples_per_tick = 1;  ///< of the log; events and steps of the input are recorded anyway
  int plan_every = 0;        ///< every so many ticks the plan is kept; 0: never
  /// Of ticks of a receding horizon whose constraints could not be met the problem is kept, of so
  /// many at most: between ticks, so that they take no longer.
  int keep_unmet = 0;
  Disturbances disturbances = {};  ///< what the plant does not share with the model
  /// What may be missed of the problem's hard constraints before LoopLog::misses has it.
  MissTolerance tolerance = {};
  /// Names and units for the tables: "height [m]".
  std::vector<std::string> state_names = {}, input_names = {};
  /// Before every tick, with what the controller will see: the moment to set data, references and
  /// event times.
  std::function<void(double t, const VectorRef& measured)> before_tick = {};
  /// For every event of the plant, as soon as the piece of the input in which it falls is over.
  std::function<void(const HybridEvent& event)> on_event = {};
  /// Ends the run early when it is true, asked after every tick with the true state.
  std::function<bool(double t, const VectorRef& state)> until = {};
};

/// Fills in the input for the measured state: as many numbers as the plant has inputs just then.
using FeedbackLaw = std::function<void(double t, const VectorRef& measured, VectorOut input)>;

/// Runs from the plant's present time and state. A plant that cannot go on, a law that returns what
/// is no number, and a formula of either that throws end the run: the log says so and keeps what
/// came before. The same arguments give the same log, but for solve times, and plans that a
/// deadline cuts off. Throws DefinitionError when sizes or options do not fit; what functions of
/// the options throw comes through.
LoopLog simulate_closed_loop(RecedingHorizonController& controller, LoopPlant& plant,
                             const LoopOptions& options);
/// A motion with an end: the plan says when the plant goes on to its next phase, where no guard
/// does, and the run is over when the plant's last phase is; a tick that would fall less than a
/// hundredth of a period before that is not made.
LoopLog simulate_closed_loop(ShrinkingHorizonController& controller, PhasedPlant& plant,
                             const LoopOptions& options);
/// Refused by the compiler in one sentence.
template <std::derived_from<LoopPlant> Plant>
  requires(!std::derived_from<Plant, PhasedPlant>)
LoopLog simulate_closed_loop(ShrinkingHorizonController&, Plant&, const LoopOptions&) {
  static_assert(std::derived_from<Plant, PhasedPlant>,
                "a ShrinkingHorizonController needs a PhasedPlant, which knows the phases of the "
                "problem; a LoopPlant of your own goes with a RecedingHorizonController");
  return {};
}
/// The same for a law u(t, x), asked every `period`.
LoopLog simulate_closed_loop(const FeedbackLaw& law, LoopPlant& plant, const LoopOptions& options);
/// The same; misses are those of the plant's problem.
LoopLog simulate_closed_loop(const FeedbackLaw& law, PhasedPlant& plant,
                             const LoopOptions& options);

}  // namespace saltus
