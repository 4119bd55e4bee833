// Receding horizon control: solves from the measured state and applies the input until the next
// tick. Every tick returns an input, also if the solve fails.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "saltus/core/clock.hpp"
#include "saltus/core/types.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/solver/optimum_check.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

// The input that a controller applies until its next tick.

class MultipleShooting;

/// Pieces that cover one tick without gaps, in order. There is one piece, or more if an event falls
/// inside the tick. The capacity is fixed. Empty before the first tick and after a move.
class HeldInput {
 public:
  /// A constant input during [start, start + length).
  struct Piece {
    double start = 0.0;   ///< absolute time in seconds
    double length = 0.0;  ///< duration in seconds
    int size = 0;         ///< dimension of the input
    VectorXd values;      ///< sized for the largest phase; the first `size` entries are valid

    /// The input of dimension `size`.
    Eigen::VectorBlock<const VectorXd> input() const { return values.head(size); }
  };

  HeldInput() = default;
  HeldInput(const HeldInput& other) = default;
  HeldInput& operator=(const HeldInput& other) = default;
  /// Leaves the other object empty.
  HeldInput(HeldInput&& other) noexcept
      : pieces_(std::move(other.pieces_)), count_(std::exchange(other.count_, 0)) {}
  /// Leaves the other object empty.
  HeldInput& operator=(HeldInput&& other) noexcept {
    pieces_ = std::move(other.pieces_);
    count_ = std::exchange(other.count_, 0);
    return *this;
  }
  ~HeldInput() = default;
  /// Allocates for the given number of pieces and input dimension. Later calls do not allocate.
  HeldInput(int pieces, int largest_input);

  /// Number of pieces.
  std::size_t size() const { return count_; }
  /// True if there is no piece.
  bool empty() const { return count_ == 0; }
  /// Piece i. Throws DefinitionError if it does not exist.
  const Piece& operator[](std::size_t i) const {
    if (i >= count_) refuse(i);
    return pieces_[i];
  }
  /// The last piece. Throws DefinitionError if there is none.
  const Piece& back() const { return (*this)[count_ - 1]; }
  /// First piece.
  std::vector<Piece>::const_iterator begin() const { return pieces_.begin(); }
  /// Past-the-end iterator.
  std::vector<Piece>::const_iterator end() const {
    return pieces_.begin() + static_cast<std::ptrdiff_t>(count_);
  }

  /// Removes all pieces.
  void clear() { count_ = 0; }
  /// Appends a piece to fill in. Throws DefinitionError if the capacity is exhausted.
  Piece& add() {
    if (count_ >= pieces_.size()) refuse(count_);
    return pieces_[count_++];
  }
  /// The last piece, mutable. Throws DefinitionError if there is none.
  Piece& last() {
    if (count_ == 0) refuse(0);
    return pieces_[count_ - 1];
  }
  /// True if all numbers are finite.
  bool all_finite() const;

 private:
  [[noreturn]] void refuse(std::size_t i) const;

  std::vector<Piece> pieces_;
  std::size_t count_ = 0;
};
/// Deprecated name.
using InputPiece [[deprecated("use HeldInput::Piece; removed in 0.4")]] = HeldInput::Piece;

/// Allocates enough pieces for a tick of any length.
HeldInput held_input_for(const MultipleShooting& shooting);

/// Extracts [t, t + period) from the plan w on the current grid: one piece for every shooting
/// interval that the tick touches. Linear inputs are sampled at the middle of their part. If the
/// plan ends before the tick, its last input is held. Does not allocate.
void hold(const MultipleShooting& shooting, const VectorXd& w, double t, double period,
          HeldInput& held);

// Histogram of durations in fixed logarithmic buckets. Counting takes a few nanoseconds and does
// not allocate; quantiles are accurate to the width of a bucket.

/// Histogram of latencies in seconds, with logarithmic buckets. There are eight buckets per factor
/// of two, from 2^-24 s (60 ns) to 2^6 s; durations outside go to the outermost buckets. A quantile
/// is the upper end of its bucket, at most 12.5 % too large.
class LatencyHistogram {
 public:
  /// Adds one duration in seconds.
  void add(double seconds);
  /// Adds all entries of the other histogram.
  void merge(const LatencyHistogram& other);

  /// Number of entries.
  long count() const { return count_; }
  /// Smallest bucket end in seconds that `fraction` of all entries do not exceed; at most max().
  double quantile(double fraction) const;
  /// Median in seconds.
  double median() const { return quantile(0.5); }
  /// 99th percentile in seconds.
  double p99() const { return quantile(0.99); }
  /// 99.9th percentile in seconds.
  double p999() const { return quantile(0.999); }
  /// Largest duration in seconds.
  double max() const { return max_; }

 private:
  static constexpr int steps = 8, lowest = -24, highest = 6;
  static int bucket(double seconds);
  std::array<std::uint32_t, (highest - lowest) * steps> counts_{};
  long count_ = 0;
  double max_ = 0.0;
};

class PlanShift;

/// Source of the input of a tick. A plan of the current tick is judged for the program itself,
/// regardless of the model that was solved. Residuals must be small in the units of the program
/// and, if the guess at set-up shows that it is badly scaled, in scaled units too. Only a
/// linear-quadratic program solved by the real-time iteration is judged in its own units alone. Its
/// weights and nominal magnitudes should then make 1e-8 negligible.
enum class Provenance {
  optimal,   ///< plan of this tick, an optimum
  feasible,  ///< plan of this tick, satisfies all rows and bounds but is not an optimum
  shifted,   ///< plan of an earlier tick, shifted; its last input is held after its end
  fallback,  ///< no plan, or none that is recent enough: the user's fallback
  step  ///< plan of this tick, a step towards the optimum that is neither optimal nor feasible yet
};
inline constexpr int provenances = 5;  ///< number of enumerators
/// Name for tables and messages.
const char* describe(Provenance provenance);
/// True if the plan was made in the current tick.
inline bool is_of_this_tick(Provenance p) {
  return p == Provenance::optimal || p == Provenance::feasible || p == Provenance::step;
}

/// Result of one tick.
struct ControlTick {
  double time = 0.0;                             ///< start of the tick in seconds
  Provenance provenance = Provenance::fallback;  ///< source of the input
  HeldInput input;                               ///< covers the tick; never empty, never NaN
  /// Reason why the solve ended; after a single step, the result of the check of its plan.
  SolveStatus status = SolveStatus::invalid_problem;
  int iterations = 0;  ///< iterations of the solver
  // Values of the program at the plan of this tick. They are infinite if no plan was made. If only
  // a model was solved (see `check`), they are infinite until the check, and if formulas fail
  // there.
  double objective = infinity;  ///< cost of the plan
  double kkt = infinity;        ///< scaled residual, see KktCheck::Residual
  double violation = infinity;  ///< largest violation of a row or bound, in scaled variables
  // Wall-clock times in seconds.
  double preparation = 0.0;  ///< duration of prepare(), called ahead or within the tick
  double feedback = 0.0;     ///< time from the measurement to the input, without preparation
  double seconds = 0.0;      ///< total time from the measurement to the input
  /// Duration of the check after the input: it evaluates the nonlinear program at the plan if only
  /// a quadratic model was solved. 0: not needed. Not part of the other times.
  double check = 0.0;
};

/// Options of a controller besides those of the solver.
struct ControllerOptions {
  double period = 0.01;        ///< control period in seconds; more than 1e-5
  double deadline = infinity;  ///< wall-clock limit per tick in seconds
  /// Largest scaled KKT residual of an "optimal" plan of the real-time iteration on a nonlinear
  /// program. Its accuracy is limited by the tolerance of the model (1e-8) and the motion of the
  /// plant. Other solvers use their own tolerance.
  double optimality = 1e-6;
  double feasibility = 1e-6;  ///< largest violation of a "feasible" plan, in scaled variables
  /// Longest use of a plan while solves fail, in seconds since its tick. After that the fallback
  /// acts until there is a plan again. The length of the horizon is a good choice. By default there
  /// is no limit: after the end of the plan its last input is held.
  double longest_shift = infinity;
  /// Applies the input. It is called as soon as the input is known, before the plan is checked, so
  /// a step on a nonlinear program still has the provenance `step` here. It must not allocate if
  /// the tick must not. Its exceptions are ignored. Without it, the input is available only when
  /// the tick returns, which is later by ControlTick::check.
  std::function<void(const ControlTick& tick)> send = {};
  VectorXd fallback_input = {};  ///< constant; empty: zero; clipped to the bounds of the inputs
  /// Fallback instead of the constant: writes the input at time t for the measured state, which may
  /// be NaN. It must not allocate if the tick must not. If it throws or writes NaN, the constant is
  /// used.
  std::function<void(double t, const VectorRef& state, VectorOut input)> fallback = {};
};

/// Counts and latencies of the ticks.
struct LoopStatistics {
  std::array<LatencyHistogram, provenances> latency;  ///< total latency, indexed by provenance
  LatencyHistogram preparation, feedback, check;      ///< parts of it, see ControlTick
  long prepared_ahead = 0;  ///< number of ticks whose preparation was done before
  /// Number of ticks with this source of the input.
  long count(Provenance p) const { return latency[static_cast<std::size_t>(p)].count(); }
  /// Latency of all ticks, regardless of the source of their input.
  LatencyHistogram all() const;
};

/// Model predictive controller whose horizon starts at the present in every tick. It shifts the
/// last plan to the new grid (plan_shift.hpp), solves from the measurement, and holds the input. If
/// solves fail repeatedly, every other one starts from the initial guess, so that a wrong
/// measurement has no lasting effect on the plan. Data, event times and the previous input are set
/// before the tick. After construction a tick never throws, and it does not allocate if the solver
/// does not. An exception of a formula or of a function of the options leads to the previous plan
/// or the fallback.
///
/// After a move, the ticks of the source object are fallbacks with an empty input, and its other
/// members throw DefinitionError.
class RecedingHorizonController : public DataByName<RecedingHorizonController> {
 public:
  /// The controller owns both. The solver must be made for this program.
  RecedingHorizonController(MultipleShooting shooting, std::unique_ptr<RealTimeSolver> solver,
                            ControllerOptions options);
  /// Uses the real-time iteration with the Riccati recursion. For other solvers see
  /// any_real_time_solver.hpp.
  RecedingHorizonController(MultipleShooting shooting, ControllerOptions options);
  ~RecedingHorizonController();
  RecedingHorizonController(RecedingHorizonController&&) noexcept;
  RecedingHorizonController& operator=(RecedingHorizonController&&) noexcept;

  /// Transcription of the problem, for changes of data and schedule between ticks.
  MultipleShooting& shooting() { return checked(); }
  /// The planned problem.
  const OptimalControlProblem& problem() const { return checked().problem(); }
  /// Control period in seconds.
  double period() const { return options_.period; }

  // Like the functions of shooting(), these throw DefinitionError for unknown names, wrong sizes
  // and a wrong order of events. However, NaN does not throw here: the next tick then uses the
  // previous plan.
  void set_entries(std::string_view name, const VectorRef& values,
                   std::span<const ParameterEntry> entries);  // behind set_data()
  /// Moves an event. The same time has no effect and keeps the preparation.
  void retime(std::string_view event, double time);
  /// Sets a schedule after an early or late event: apply Schedule::confirm and hold to a copy and
  /// set it here.
  void set_schedule(const Schedule& schedule);
  /// Sets the input before the first tick, if the problem reads it.
  void set_previous_input(const VectorRef& input);
  /// Sets the remaining durations of a shrinking horizon, before every tick:
  /// MultipleShooting::set_remaining.
  void set_remaining(Bounds first_phase, Bounds total_time);
  /// Adopts the remainder at time t of a plan made elsewhere. The next solve starts from it, and if
  /// that solve fails, the plan is used. Allocates.
  void adopt_plan(double t, const Trajectory& plan);

  /// Does all work for the tick at absolute time t that does not need the measurement: grid,
  /// shifted plan, and the part of the linearisation that later set_data() calls leave unchanged.
  /// Optional; call it before the measurement arrives. Data may change afterwards; a new schedule
  /// repeats the work in the tick.
  void prepare(double t) noexcept;
  /// Runs the tick at the prepared time. The controller owns the result, which is valid until the
  /// next tick.
  const ControlTick& feedback(const VectorRef& state) noexcept;
  /// Calls both. A time that is not finite is replaced by the prepared time or, without one, by one
  /// period after the last tick.
  const ControlTick& tick(double t, const VectorRef& state) noexcept;

  /// True if the last input came from a plan, or a plan was adopted since.
  bool follows_plan() const { return tick_.provenance != Provenance::fallback; }
  /// Statistics of all ticks so far.
  const LoopStatistics& statistics() const { return statistics_; }
  /// Name of the solver of the ticks.
  std::string solver_name() const;
  /// End time in seconds of this phase in the plan of the last tick. Throws DefinitionError if the
  /// problem has no such phase.
  double end_of_phase(int phase) const;
  /// The plan of the last tick with all costs and residuals recomputed. Call it outside the loop,
  /// before anything is changed. Its status is that of the tick: ok() is false if the plan is not
  /// known to satisfy its constraints. Allocates, and formulas may throw.
  ///
  /// If the tick made no plan, status, iterations and the start of the message describe its solve.
  /// Trajectory, costs, residuals and the terms in the message describe the source of the input:
  /// the fallback, or the plan of an earlier tick on the current grid, which does not start at the
  /// measurement.
  Solution report();

 private:
  // State of the preparation for the next tick. prepare() leads to `ready` or `impossible`. From
  // there, changes of the schedule, the horizon or the plan lead to `outdated`. Every tick leads to
  // `none`.
  enum class Preparation {
    none,       // the time of the next tick is unknown
    outdated,   // the time is known; everything else must be prepared again
    ready,      // grid, guess and model are those of the next tick
    impossible  // the terms contradict each other on the grid of the next tick: the old grid stays
  };
  // Origin of the last accepted plan.
  enum class Plan {
    none,     // there is none
    adopted,  // adopt_plan(): a trajectory without multipliers
    solved    // a tick
  };
  // Validity of the last measured state.
  enum class Measurement { usable, wrong_size, not_finite };
  // Judge of the plan of a tick: its solver, or the check that follows the input.
  enum class Judge { solver, check };

  MultipleShooting& checked() const;
  bool is_prepared() const;
  void outdate();
  bool restarts() const;
  Measurement examine(const VectorRef& state) const;
  Provenance without_solve() const;
  const ControlTick& answer(const VectorRef& state, WallClock::time_point begin,
                            bool prepared_late) noexcept;
  Judge solve(const VectorRef& state, WallClock::time_point begin);
  void check_plan() noexcept;
  void fall_back(const VectorRef& state);

  std::unique_ptr<MultipleShooting> shooting_;
  std::unique_ptr<RealTimeSolver> solver_;
  ControllerOptions options_;
  std::unique_ptr<PlanShift> shift_;
  KktCheck check_;
  std::optional<ProgramScale> scale_;  // scale of its values if badly scaled
  NlpPoint initial_;                   // start of the first solve
  NlpPoint plan_;                      // last accepted plan, on the grid of shift_
  NlpPoint guess_, point_;             // on the current grid
  Preparation preparation_ = Preparation::none;
  Plan last_plan_ = Plan::none;
  Measurement measurement_ = Measurement::usable;
  Eigen::Index measured_size_ = 0;    // number of entries of the last measured state
  bool has_bad_data_ = false;         // data set since the last tick are not finite
  double made_at_ = 0.0;              // time in seconds of the tick that made the plan
  int failures_ = 0;                  // consecutive failed solves, missed deadlines not counted
  double preparation_seconds_ = 0.0;  // duration of the last prepare()
  double now_ = 0.0;                  // time in seconds of the last tick, or of the next if known
  VectorXd fallback_;
  ControlTick tick_;
  LoopStatistics statistics_;
};

}  // namespace saltus
