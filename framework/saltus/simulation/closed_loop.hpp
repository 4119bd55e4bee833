// Closed-loop simulation: in every control period the controller measures the state of the plant,
// with noise and delay, and the plant advances under its input and the disturbances.
//
//     RecedingHorizonController controller(MultipleShooting(problem, grid), {.period = 0.1});
//     IntegratorPlant plant = nominal_plant(problem, cvodes());
//     const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 5.0});
//     log.write("results/car");
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/mpc/shrinking_horizon.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/simulation/plants.hpp"

namespace saltus {

// Differences between a plant and the model of its controller: forces, noise, delays.

/// Noise, delays, pulses and other disturbances of a closed loop. All disturbances are off by
/// default. The same seed gives the same run on every machine. For a mismatch of parameters, give
/// the plant its own parameters.
struct Disturbances {
  /// Disturbance added to the input of the plant. Called at the start of every piece of the input
  /// with the true state; writes `added` (nu), which is zero on entry.
  std::function<void(double t, const VectorRef& state, VectorOut added)> input = {};
  /// Disturbance of the state at the start of every tick, before the measurement; writes `added`
  /// (nx).
  std::function<void(double t, const VectorRef& state, VectorOut added)> state = {};
  /// Pushes, gusts and other impulses. The plant applies them itself (LoopPlant::take_pulses()), or
  /// their part in each piece of the input is added to the state at its start.
  std::vector<Pulse> pulses = {};
  /// Standard deviations (nx) of white Gaussian noise; empty: none.
  VectorXd state_noise = {};        ///< added to the state at the start of every tick
  VectorXd measurement_noise = {};  ///< added to the measured state only
  std::uint64_t seed = 1;           ///< seed of the noise
  /// Delay of the measured state in seconds; a multiple of the control period.
  double measurement_delay = 0.0;
  /// Delay of the input in seconds. Until then `first_input` is applied.
  double input_delay = 0.0;
  VectorXd first_input = {};  ///< input before the first one arrives (nu); empty: zero
};

/// Options of a closed-loop run and its log.
struct LoopOptions {
  /// Length in seconds; the last tick may end slightly later. Infinite: the run ends when `until`
  /// is true.
  double duration = 1.0;
  double period = 0.01;      ///< period of a feedback law in seconds; controllers have their own
  int samples_per_tick = 1;  ///< samples of the log; events and input steps are always recorded
  /// False: the recording stays empty, for plants that keep a record of their own.
  bool record = true;
  int plan_every = 0;  ///< a plan is stored every so many ticks; 0: never
  /// Number of ticks of a receding horizon with unsatisfied constraints whose problems are stored.
  /// They are stored between ticks, so that ticks take no longer.
  int keep_unmet = 0;
  Disturbances disturbances = {};  ///< differences between the plant and the model
  /// Tolerances of the problem's hard constraints; larger violations appear in LoopLog::misses.
  MissRecord::Tolerance tolerance = {};
  /// Column names with units: "height [m]".
  std::vector<std::string> state_names = {}, input_names = {};
  /// Folder whose trajectory.csv and events.csv are rewritten during the run, about twice per
  /// second of wall-clock time and outside the ticks, for `saltus view --live`; empty: never.
  std::string live_folder = {};
  /// Called before every tick with the measured state, to set data, references and event times.
  std::function<void(double t, const VectorRef& measured)> before_tick = {};
  /// Called for every event of the plant, at the end of the input piece that contains it.
  std::function<void(const HybridEvent& event)> on_event = {};
  /// Called after every tick with the true state; true ends the run.
  std::function<bool(double t, const VectorRef& state)> until = {};
};

/// Writes the input for the measured state. The size is the current number of inputs of the plant.
using FeedbackLaw = std::function<void(double t, const VectorRef& measured, VectorOut input)>;

/// A user-defined controller. It may run its parts at multiples of its period.
class LoopController {
 public:
  virtual ~LoopController() = default;
  /// Time between two ticks in seconds.
  virtual double period() const = 0;
  /// The input from `t` on, in one piece or more. It stays valid until the next call.
  virtual const HeldInput& tick(double t, const VectorRef& measured) = 0;
  /// Record of the last tick for the log. Empty: nothing is recorded, for example between the ticks
  /// of a planner that runs at a multiple of the period. Called after every tick.
  virtual std::optional<LoopLog::Tick> last_tick() { return LoopLog::Tick{}; }
  /// Name for messages and results.
  virtual std::string name() const = 0;
};

/// Runs from the current time and state of the plant. The run ends early if the plant cannot
/// advance, a law returns NaN, or a formula of either throws; the log reports it and keeps the
/// results until then. The same arguments give the same log, except for solve times and for plans
/// cut off by a deadline. Throws DefinitionError for invalid sizes or options. Exceptions of
/// functions of the options propagate.
LoopLog simulate_closed_loop(RecedingHorizonController& controller, LoopPlant& plant,
                             const LoopOptions& options);
/// Runs a motion with an end. The plan determines when the plant enters its next phase, unless a
/// guard does. The run ends with the last phase of the plant. A tick less than a hundredth of a
/// period before the end is skipped.
LoopLog simulate_closed_loop(ShrinkingHorizonController& controller, PhasedPlant& plant,
                             const LoopOptions& options);
/// The same for a plant without phases. The plan determines the end of a phase, unless the phase
/// has a guard. Then it ends with an event of the guard's name (LoopPlant::take_events()), or at
/// the end of the sample in which the guard changes its sign. Each new phase calls
/// LoopPlant::enter_phase(). A plant whose state or input does not fit the new phase ends the run.
LoopLog simulate_closed_loop(ShrinkingHorizonController& controller, LoopPlant& plant,
                             const LoopOptions& options);
/// The same for a user-defined controller. Its problem is not known, so nothing is judged.
LoopLog simulate_closed_loop(LoopController& controller, LoopPlant& plant,
                             const LoopOptions& options);
/// The same for a law u(t, x), evaluated every `period`.
LoopLog simulate_closed_loop(const FeedbackLaw& law, LoopPlant& plant, const LoopOptions& options);
/// The same; misses refer to the plant's problem.
LoopLog simulate_closed_loop(const FeedbackLaw& law, PhasedPlant& plant,
                             const LoopOptions& options);

}  // namespace saltus
