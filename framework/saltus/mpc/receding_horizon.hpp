// Receding horizon control: solve from the measured state, hand over the input until the next tick,
// and hand over some input whatever happens.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "saltus/core/clock.hpp"
#include "saltus/mpc/held_input.hpp"
#include "saltus/mpc/latency_histogram.hpp"
#include "saltus/mpc/real_time_solver.hpp"
#include "saltus/solver/kkt.hpp"
#include "saltus/solver/program_scale.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/plan_shift.hpp"

namespace saltus {

/// Where the input of a tick comes from. Of a plan made in the tick: what it is for the program
/// itself, whatever model of it was solved. What counts are residuals in the units of the program
/// and, where its guess tells at set-up that its numbers are of no usual size, in theirs too.
/// Only a linear-quadratic program that is solved by an iteration is measured in its own units
/// alone: weights and magnitudes (nominal) are to be such that 1e-8 is little.
enum class Provenance {
  optimal,   ///< of the plan made in this tick, an optimum
  feasible,  ///< of the plan made in this tick, within all rows and bounds, but no optimum
  shifted,   ///< the plan of an earlier tick goes on, where it is over its last input
  fallback,  ///< there is no plan, or none that is new enough: what the user supplied for that case
  step       ///< of the plan made in this tick, a step towards the optimum that is neither yet
};
inline constexpr int provenances = 5;  ///< how many kinds there are
/// In words, for tables and messages.
const char* describe(Provenance provenance);
/// Whether the plan behind the input was made in the tick itself.
inline bool is_of_this_tick(Provenance p) {
  return p == Provenance::optimal || p == Provenance::feasible || p == Provenance::step;
}

/// What one tick gave.
struct ControlTick {
  double time = 0.0;                             ///< s
  Provenance provenance = Provenance::fallback;  ///< where the input comes from
  HeldInput input;                               ///< covers the tick; never empty, never NaN
  /// Why this tick's solve ended; where it took one step, what the check found of its plan.
  SolveStatus status = SolveStatus::invalid_problem;
  int iterations = 0;  ///< of the solver
  // Of the program at the plan of this tick; where only a model of it was solved (see `check`)
  // they are infinite until the check, and if formulas fail there; and where no plan was made.
  double objective = infinity;  ///< cost of the plan
  double kkt = infinity;        ///< scaled residual, see KktResidual
  double violation = infinity;  ///< largest one of a row or bound, in scaled variables
  // Wall clock, s.
  double preparation = 0.0;  ///< of prepare(), whether it was called ahead or was due in the tick
  double feedback = 0.0;     ///< from the measurement to the input, without preparation
  double seconds = 0.0;      ///< from the measurement to the input, all in all
  /// Of the check that follows the input: the nonlinear program, of which one quadratic model was
  /// solved, is evaluated at the plan. 0: it was not needed. Not part of the others.
  double check = 0.0;
};

/// What a controller does besides solving.
struct ControllerOptions {
  double period = 0.01;        ///< between ticks, s; more than 1e-5
  double deadline = infinity;  ///< wall clock per tick, s
  /// Largest scaled KKT residual of an "optimal" plan of a real-time iteration on a nonlinear
  /// program: steps end where the model's own tolerance (1e-8) and the motion of the plant let
  /// them. What solves the program itself has a tolerance of its own.
  double optimality = 1e-6;
  double feasibility = 1e-6;  ///< largest violation of a "feasible" plan, in scaled variables
  /// How long a plan goes on where solves fail, s since the tick that made it; then the fallback
  /// acts until there is a plan again. The horizon's length is a good choice: behind it the last
  /// input of the plan is held, for ever if nothing is said.
  double longest_shift = infinity;
  /// The moment to apply the input: called as soon as it stands, before the plan is checked, so
  /// that a step on a nonlinear program is still a `step` here. Must not allocate if the tick must
  /// not; what it throws is dropped. Without it the input is there when the tick returns, which is
  /// ControlTick::check later.
  std::function<void(const ControlTick& tick)> send = {};
  VectorXd fallback_input = {};  ///< constant; empty: zero. Cut to the bounds of the inputs
  /// In place of the constant: fills in the input at time t for the measured state, which may be
  /// NaN. Must not allocate if the tick must not; what it throws, or NaN, leads to the constant.
  std::function<void(double t, const VectorRef& state, VectorOut input)> fallback = {};
  /// For tests of the loop: the solver gets no time at all in ticks for which this is true, or
  /// which it leaves by an exception.
  std::function<bool(long tick)> miss_deadline = {};
};

/// How often, and how long it took.
struct LoopStatistics {
  std::array<LatencyHistogram, provenances> latency;  ///< all in all, indexed by provenance
  LatencyHistogram preparation, feedback, check;      ///< apart, see ControlTick
  long prepared_ahead = 0;                            ///< ticks that found their preparation done
  /// How many ticks got their input from there.
  long count(Provenance p) const { return latency[static_cast<std::size_t>(p)].count(); }
  /// Of all ticks, wherever their input came from.
  LatencyHistogram all() const;
};

/// Every tick: the last plan is moved on to the new grid (plan_shift.hpp), solved again from the
/// measurement, and held. Where solves fail again and again, every other one starts where the very
/// first did: what a wrong measurement did to the plan does not last. Data, event times and the
/// previous input are set before the tick. After construction a tick does not allocate, if the
/// solver does not, and never throws: what a formula or a function of the options throws, whatever
/// it is, leads to the plan before or the fallback.
///
/// A controller that was moved from has no program any more: its ticks are fallbacks with an empty
/// input, and its other members throw DefinitionError.
class RecedingHorizonController : public DataByName<RecedingHorizonController> {
 public:
  /// The controller owns both; the solver belongs to this program.
  RecedingHorizonController(MultipleShooting shooting, std::unique_ptr<RealTimeSolver> solver,
                            ControllerOptions options);
  /// With the real-time iteration, stage by stage. Others by name: any_real_time_solver.hpp.
  RecedingHorizonController(MultipleShooting shooting, ControllerOptions options);

  /// Its program, for data and schedule between ticks.
  MultipleShooting& shooting() { return checked(); }
  /// What it plans.
  const OptimalControlProblem& problem() const { return checked().problem(); }
  /// Of the ticks, s.
  double period() const { return options_.period; }

  // Like those of shooting(), which throw DefinitionError for names, sizes and orders of events
  // that are wrong, but what is no number makes the next tick go on with its plan instead of
  // throwing.
  void set_entries(std::string_view name, const VectorRef& values,
                   std::span<const ParameterEntry> entries);  // behind set_data()
  /// To the same time: nothing happens, and what was prepared stays so.
  void retime(std::string_view event, double time);
  /// An event that came early or late: Schedule::confirm and hold on a copy of the schedule, which
  /// is then set here.
  void set_schedule(const Schedule& schedule);
  /// What acted on the plant before the first tick, where the problem reads it.
  void set_previous_input(const VectorRef& input);
  /// For a horizon that shrinks, before every tick: MultipleShooting::set_remaining.
  void set_remaining(Bounds first_phase, Bounds total_time);
  /// Begins with what is left at time t of a plan made elsewhere: it is where the next solve
  /// starts, and goes on where that fails. Allocates.
  void adopt_plan(double t, const Trajectory& plan);

  /// Everything for the tick at absolute time t that does not need the measurement: grid, shifted
  /// plan, and of the linearisation what later calls of set_data() leave as it is. Optional; to be
  /// called ahead of the tick, when the measurement is not there yet. Data may change afterwards;
  /// another schedule has it done again in the tick.
  void prepare(double t) noexcept;
  /// The tick at the time prepared for. The result is the controller's and lasts until the next.
  const ControlTick& feedback(const VectorRef& state) noexcept;
  /// Both. A time that is no number stands for the one prepared for or, without any, for one period
  /// after the last tick.
  const ControlTick& tick(double t, const VectorRef& state) noexcept;

  /// Whether the last input was of a plan, or one was adopted since.
  bool follows_plan() const { return tick_.provenance != Provenance::fallback; }
  /// Of all ticks so far.
  const LoopStatistics& statistics() const { return statistics_; }
  /// Of what solves the ticks.
  std::string solver_name() const;
  /// When the plan behind the last tick's input ends this phase, s. Throws DefinitionError unless
  /// the problem has the phase.
  double end_of_phase(int phase) const;
  /// The plan behind the last tick's input with all its costs and residuals recomputed: outside the
  /// loop, before anything is changed. Its status is the tick's, so that ok() is false where the
  /// plan is not known to be within its constraints. Allocates, and formulas that throw are heard.
  ///
  /// Where the tick came to no plan, status, iterations and the first words of the message are of
  /// its solve; trajectory, costs, residuals and what the message says of terms are of what the
  /// input was taken from: the plan of an earlier tick moved on to the grid of this one, which does
  /// not begin at the measurement, or the fallback held all along.
  Solution report();

 private:
  MultipleShooting& checked() const;
  const ControlTick& answer(const VectorRef& state, WallClock::time_point begin,
                            bool prepared_late) noexcept;
  void solve(const VectorRef& state, WallClock::time_point begin);
  void check_plan() noexcept;
  void fall_back(const VectorRef& state);
  bool is_measured(const VectorRef& state) const;
  Provenance without_solve() const;

  std::unique_ptr<MultipleShooting> shooting_;
  std::unique_ptr<RealTimeSolver> solver_;
  ControllerOptions options_;
  PlanShift shift_;
  KktCheck check_;
  std::optional<ProgramScale> scale_;  // of its values, where they are of no usual size
  NlpPoint initial_;                   // where the first solve starts
  NlpPoint plan_;           // the last one that was accepted, on the grid that shift_ remembers
  NlpPoint guess_, point_;  // on the present grid
  bool has_plan_ = false, has_multipliers_ = false, is_prepared_ = false, has_bad_data_ = false;
  bool has_bad_grid_ = false;  // of the last prepare()
  bool has_time_ = false;      // now_ is of the next tick: prepare() was told
  bool is_of_model_ = false;   // what the present tick knows of its plan
  double made_at_ = 0.0;       // s, the tick that made the plan
  // What was wrong with the last measurement: its size, or -1: nothing, -2: an entry.
  Eigen::Index bad_measurement_ = -1;
  int failures_ = 0;          // solves in a row that came to nothing, for want of time apart
  bool begins_anew_ = false;  // where the problem's guess is, not where the last plan is
  double preparation_ = 0.0;  // s, of the last prepare()
  double now_ = 0.0;
  long ticks_ = 0;
  VectorXd fallback_;
  ControlTick tick_;
  LoopStatistics statistics_;
};

}  // namespace saltus
