#include "saltus/mpc/receding_horizon.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/solver/infeasibility_proof.hpp"
#include "saltus/solver/presolve.hpp"
#include "saltus/transcription/plan_shift.hpp"
#include "saltus/transcription/quantities.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

// Shortest control period, s. The part of the plan in a shorter tick would be empty or dominated by
// rounding.
constexpr double shortest_period = 10.0 * same_instant;
constexpr double doubtful_gain = 1e-4;  // a larger relative gain in cost disproves an optimum

// has_arrived(): a solve ended at a usable point. was_cut_off(): it stopped early at a point that
// may be usable.
bool has_arrived(SolveStatus status) {
  return is_success(status) || status == SolveStatus::step_taken;
}
bool was_cut_off(SolveStatus status) {
  return status == SolveStatus::time_limit || status == SolveStatus::iteration_limit ||
         status == SolveStatus::numerical_failure;
}

// Scale in which single-step plans are judged in addition to the units of the program. Empty if the
// program is well scaled or its scale is unknown. Uses a second transcription, because this one
// must not be evaluated before its first tick.
std::optional<ProgramScale> scale_of(MultipleShooting& shooting, const VectorXd& guess) {
  if (shooting.nlp().is_linear_quadratic() || !shooting.options().automatic_scale) return {};
  try {
    MultipleShooting other(shooting.problem(), shooting.options());
    ProgramSize size(other.nlp(), undeclared_quantities(other.program()));
    const ProgramScale as_it_is{1.0, VectorXd::Ones(other.nlp().rows())};
    // Variables that are zero in the guess may reach their bounds, unless a bound only represents
    // infinity.
    constexpr double placeholder = 1e8;
    VectorXd reached = guess;
    for (int i = 0; i < reached.size(); ++i)
      for (const double side : {other.nlp().lower()[i], other.nlp().upper()[i]})
        if (guess[i] == 0.0 && std::abs(side) < placeholder &&
            std::abs(side) > std::abs(reached[i]))
          reached[i] = side;
    if (size.look_at(guess) && size.look_at(reached) && !size.is_well_scaled_where_known(as_it_is))
      return size.to_one();
  } catch (...) {  // a formula threw at the guess: the scale is unknown
  }
  return {};
}

}  // namespace

const char* describe(Provenance provenance) {
  switch (provenance) {
    case Provenance::optimal:
      return "optimal";
    case Provenance::feasible:
      return "feasible";
    case Provenance::shifted:
      return "shifted";
    case Provenance::fallback:
      return "fallback";
    case Provenance::step:
      return "step";
  }
  return "unknown";
}

LatencyHistogram LoopStatistics::all() const {
  LatencyHistogram sum;
  for (const LatencyHistogram& h : latency) sum.merge(h);
  return sum;
}

RecedingHorizonController::RecedingHorizonController(MultipleShooting shooting,
                                                     std::unique_ptr<RealTimeSolver> solver,
                                                     ControllerOptions options)
    : shooting_(std::make_unique<MultipleShooting>(std::move(shooting))),
      solver_(std::move(solver)),
      options_(std::move(options)),
      shift_(std::make_unique<PlanShift>(shooting_->program())),
      check_(shooting_->nlp()) {
  const PhaseDefinition& first = shooting_->problem().phases().front();
  if (const int threads = shooting_->options().threads; threads != 1)
    throw DefinitionError(fmt::format(
        "controller: ShootingOptions::threads is {}, but ticks must not wait for other threads: "
        "leave it at 1",
        threads));
  if (!(options_.period > shortest_period && std::isfinite(options_.period)))
    throw DefinitionError(
        fmt::format("controller: the period is {} s, expected more than {:.0e} s: times closer "
                    "than {:.0e} s count as equal",
                    options_.period, shortest_period, same_instant));
  if (!(options_.deadline > 0.0))
    throw DefinitionError(
        fmt::format("controller: the deadline is {} s, expected more than 0", options_.deadline));
  if (std::isfinite(options_.deadline) && options_.deadline > options_.period + same_instant)
    throw DefinitionError(
        fmt::format("controller: the deadline of {} s is longer than the period of {} s",
                    options_.deadline, options_.period));
  double horizon = 0.0;
  for (const PhaseDefinition& phase : shooting_->problem().phases())
    horizon += phase.duration.upper;
  if (options_.period > horizon + same_instant)
    throw DefinitionError(
        fmt::format("controller: the period of {} s is longer than the horizon of {} s",
                    options_.period, horizon));
  for (const auto& [name, tolerance] :
       {std::pair{"optimality", options_.optimality}, {"feasibility", options_.feasibility}})
    if (!(tolerance > 0.0))
      throw DefinitionError(fmt::format(
          "controller: the tolerance '{}' is {}, expected more than 0", name, tolerance));
  if (!(options_.longest_shift >= 0.0))
    throw DefinitionError(fmt::format("controller: the longest shift is {} s, expected 0 or more",
                                      options_.longest_shift));
  if (options_.fallback_input.size() == 0) options_.fallback_input = VectorXd::Zero(first.sizes.nu);
  if (options_.fallback_input.size() != first.sizes.nu || !options_.fallback_input.allFinite())
    throw DefinitionError(
        fmt::format("controller: the fallback input has {} entries, expected {} numbers",
                    options_.fallback_input.size(), first.sizes.nu));
  if (shooting_->problem().start_time_bounds())
    throw DefinitionError(
        fmt::format("controller: the start time of problem '{}' is free, but a tick starts at a "
                    "given time; give start_time() a number",
                    shooting_->problem().name()));
  const NonlinearProgram& nlp = shooting_->nlp();
  initial_ = shooting_->initial_guess();
  initial_.lambda = VectorXd::Zero(nlp.rows());
  initial_.z = VectorXd::Zero(nlp.variables());
  plan_ = guess_ = point_ = initial_;
  scale_ = scale_of(*shooting_, initial_.w);
  shift_->remember(shooting_->program(), initial_.w);
  fallback_ = options_.fallback_input;
  now_ = shooting_->data().start_time - options_.period;
  tick_.input = held_input_for(*shooting_);
}

RecedingHorizonController::RecedingHorizonController(MultipleShooting shooting,
                                                     ControllerOptions options)
    : RecedingHorizonController(std::move(shooting), nullptr, std::move(options)) {
  solver_ = make_real_time_iteration(shooting_->nlp());
}

RecedingHorizonController::~RecedingHorizonController() = default;
RecedingHorizonController::RecedingHorizonController(RecedingHorizonController&&) noexcept =
    default;
RecedingHorizonController& RecedingHorizonController::operator=(
    RecedingHorizonController&&) noexcept = default;

MultipleShooting& RecedingHorizonController::checked() const {
  if (!shooting_) throw DefinitionError("controller: it has been moved from");
  return *shooting_;
}

std::string RecedingHorizonController::solver_name() const {
  checked();
  return solver_->name();
}

void RecedingHorizonController::set_entries(std::string_view name, const VectorRef& values,
                                            std::span<const ParameterEntry> entries) {
  if (values.allFinite())
    checked().set_entries(name, values, entries);
  else
    has_bad_data_ = true;
  if (!values.allFinite()) outdate();
}

void RecedingHorizonController::retime(std::string_view event, double time) {
  if (time == checked().data().schedule.time_of(event)) return;
  if (std::isnan(time))
    has_bad_data_ = true;
  else
    shooting_->retime(event, time);
  outdate();  // the guess is on the old grid
}

void RecedingHorizonController::set_schedule(const Schedule& schedule) {
  if (schedule == checked().data().schedule) return;
  shooting_->set_schedule(schedule);
  outdate();
}

void RecedingHorizonController::set_previous_input(const VectorRef& input) {
  if ((input.array().abs() == infinity).any())
    has_bad_data_ = true;
  else
    checked().set_previous_input(input);
}

void RecedingHorizonController::set_remaining(Bounds first_phase, Bounds total_time) {
  checked().set_remaining(first_phase, total_time);
  outdate();
}

void RecedingHorizonController::adopt_plan(double t, const Trajectory& plan) {
  if (plan.empty()) throw DefinitionError("controller: the plan to adopt is empty");
  checked().start_time(t);
  VectorXd w = shooting_->guess_from(plan).w;
  if (!w.allFinite()) throw DefinitionError("controller: the plan to adopt is not finite");
  plan_.w = std::move(w);
  plan_.lambda.setZero(initial_.lambda.size());
  plan_.z.setZero(initial_.z.size());
  shift_->remember(shooting_->program(), plan_.w);
  guess_ = plan_;
  tick_.provenance = Provenance::shifted;
  last_plan_ = Plan::adopted;
  made_at_ = t;
  failures_ = 0;  // these belong to the previous plan
  outdate();
}

bool RecedingHorizonController::is_prepared() const {
  return preparation_ == Preparation::ready || preparation_ == Preparation::impossible;
}

void RecedingHorizonController::outdate() {
  if (is_prepared()) preparation_ = Preparation::outdated;
}

// Iterations may not recover from a plan that follows a wrong measurement. After two consecutive
// failures, every other solve therefore starts at the guess of the problem.
bool RecedingHorizonController::restarts() const {
  return last_plan_ != Plan::none && failures_ >= 2 && failures_ % 2 == 0;
}

RecedingHorizonController::Measurement RecedingHorizonController::examine(
    const VectorRef& state) const {
  if (!state.allFinite()) return Measurement::not_finite;
  const bool fits = state.size() == shooting_->problem().phases().front().sizes.nx;
  return fits ? Measurement::usable : Measurement::wrong_size;
}

// Source of the input if the tick makes no plan.
Provenance RecedingHorizonController::without_solve() const {
  const bool is_too_old = now_ - made_at_ > options_.longest_shift + same_instant;
  return last_plan_ != Plan::none && !is_too_old ? Provenance::shifted : Provenance::fallback;
}

void RecedingHorizonController::prepare(double t) noexcept {
  if (!shooting_) return;
  const WallClock::time_point begin = WallClock::now();
  if (std::isfinite(t))
    now_ = t;
  else if (preparation_ == Preparation::none)
    now_ += options_.period;
  try {
    shooting_->start_time(now_);
    preparation_ = Preparation::ready;
  } catch (...) {
    preparation_ = Preparation::impossible;
  }
  if (last_plan_ != Plan::none) {
    shift_->apply(shooting_->program(), plan_, guess_);
  } else {  // the guess of the problem is relative to the start of the horizon
    guess_ = initial_;
    const NonlinearProgram& nlp = shooting_->nlp();
    guess_.w = guess_.w.cwiseMax(nlp.lower()).cwiseMin(nlp.upper());
  }
  solver_->prepare(shooting_->nlp(), restarts() ? initial_ : guess_);
  preparation_seconds_ = seconds_since(begin);
}

const ControlTick& RecedingHorizonController::feedback(const VectorRef& state) noexcept {
  const WallClock::time_point begin = WallClock::now();
  const bool is_due = !is_prepared();
  if (is_due) prepare(preparation_ == Preparation::none ? now_ + options_.period : now_);
  return answer(state, begin, is_due);
}

const ControlTick& RecedingHorizonController::tick(double t, const VectorRef& state) noexcept {
  const WallClock::time_point begin = WallClock::now();
  const bool is_due = !is_prepared() || (std::isfinite(t) && t != now_);
  if (is_due) prepare(t);
  return answer(state, begin, is_due);
}

const ControlTick& RecedingHorizonController::answer(const VectorRef& state,
                                                     WallClock::time_point begin,
                                                     bool prepared_late) noexcept {
  if (!shooting_) return tick_ = {};
  tick_.time = now_;
  tick_.status = SolveStatus::invalid_problem;
  tick_.iterations = 0;
  tick_.check = 0.0;
  tick_.objective = tick_.kkt = tick_.violation = infinity;
  tick_.provenance = without_solve();
  measurement_ = examine(state);
  measured_size_ = state.size();
  const bool can_be_solved =
      measurement_ == Measurement::usable && !has_bad_data_ && preparation_ == Preparation::ready;
  Judge judge = Judge::solver;
  try {
    if (can_be_solved) judge = solve(state, begin);
  } catch (...) {  // the program of this tick is invalid
    tick_.provenance = without_solve();
  }
  const bool accepted = is_of_this_tick(tick_.provenance);
  if (!accepted) tick_.objective = tick_.kkt = tick_.violation = infinity;
  if (accepted) {
    std::swap(plan_, point_);
    shift_->remember(shooting_->program(), plan_.w);
    last_plan_ = Plan::solved;
    made_at_ = now_;
    failures_ = 0;
  } else if (can_be_solved && tick_.status != SolveStatus::time_limit) {
    ++failures_;
  }
  if (tick_.provenance != Provenance::fallback)
    hold(*shooting_, accepted ? plan_.w : guess_.w, now_, options_.period, tick_.input);
  if (tick_.provenance == Provenance::fallback || !tick_.input.all_finite()) fall_back(state);
  preparation_ = Preparation::none;
  has_bad_data_ = false;
  tick_.seconds = seconds_since(begin);
  tick_.preparation = preparation_seconds_;
  tick_.feedback = tick_.seconds - (prepared_late ? preparation_seconds_ : 0.0);
  if (options_.send) {
    try {
      options_.send(tick_);
    } catch (...) {  // the input is valid even if sending it failed
    }
  }
  if (is_of_this_tick(tick_.provenance) && judge == Judge::check) check_plan();
  statistics_.preparation.add(tick_.preparation);
  statistics_.feedback.add(tick_.feedback);
  if (tick_.check > 0.0) statistics_.check.add(tick_.check);
  if (!prepared_late) ++statistics_.prepared_ahead;
  statistics_.latency[static_cast<std::size_t>(tick_.provenance)].add(tick_.seconds);
  return tick_;
}

// Judges the plan for the program itself: an optimum, a feasible point, or neither.
void RecedingHorizonController::check_plan() noexcept {
  const WallClock::time_point begin = WallClock::now();
  try {
    NonlinearProgram& nlp = shooting_->nlp();
    const KktCheck::Residual residual = check_(nlp, plan_);
    if (nlp.objective(plan_.w.data(), tick_.objective)) {
      tick_.kkt = residual.scaled();
      tick_.violation = residual.feasibility;
      if (scale_) {
        const KktCheck::Residual in_scale = check_(nlp, plan_, *scale_);
        tick_.kkt = std::max(tick_.kkt, in_scale.scaled());
        tick_.violation = std::max(tick_.violation, in_scale.feasibility);
      }
    }
  } catch (...) {  // a formula threw: the plan stays unchecked; the input is already sent
  }
  if (tick_.violation <= options_.feasibility) {
    const bool is_optimal = tick_.kkt <= options_.optimality;
    tick_.provenance = is_optimal ? Provenance::optimal : Provenance::feasible;
    if (tick_.status == SolveStatus::step_taken)
      tick_.status = is_optimal ? SolveStatus::optimal : SolveStatus::feasible;
    // Rounding may stop a solver at an optimum.
    if (is_optimal && tick_.status == SolveStatus::numerical_failure)
      tick_.status = SolveStatus::optimal;
  }
  tick_.check = seconds_since(begin);
}

RecedingHorizonController::Judge RecedingHorizonController::solve(const VectorRef& state,
                                                                  WallClock::time_point begin) {
  NonlinearProgram& nlp = shooting_->nlp();
  shooting_->start_at(now_, state);
  const WallClock::time_point deadline = seconds_after(begin, options_.deadline);
  // The result of a linear-quadratic program does not depend on the guess.
  const bool as_it_was = last_plan_ != Plan::none && failures_ == 0 && nlp.is_linear_quadratic() &&
                         shift_->is_same_horizon(shooting_->program(), plan_.w);
  point_ = restarts() ? initial_ : as_it_was ? plan_ : guess_;
  const bool warm = last_plan_ == Plan::solved && !restarts();
  const RealTimeSolver::Result r = solver_->feedback(nlp, point_, warm, deadline);
  const bool is_whole = point_.w.size() == nlp.variables() && point_.w.allFinite() &&
                        point_.lambda.allFinite() && point_.z.allFinite();
  tick_.iterations = r.iterations;
  tick_.status = is_whole || !has_arrived(r.status) ? r.status : SolveStatus::numerical_failure;
  if (!r.of_model) {
    tick_.objective = r.objective;
    tick_.kkt = r.kkt;
    tick_.violation = r.violation;
  }
  const bool is_within = r.violation <= options_.feasibility;
  const Judge judge = r.of_model ? Judge::check : Judge::solver;
  if (!is_whole || !(has_arrived(r.status) || (was_cut_off(r.status) && is_within))) return judge;
  const bool is_optimal = r.status == SolveStatus::optimal ||
                          (is_success(r.status) && is_within && r.kkt <= options_.optimality);
  if (r.of_model)
    tick_.provenance = Provenance::step;  // until it is checked
  else if (is_optimal)
    tick_.provenance = Provenance::optimal;
  else
    tick_.provenance = is_within ? Provenance::feasible : Provenance::step;
  // A point may exceed the bounds by the solver's tolerance. The input must not.
  point_.w = point_.w.cwiseMax(nlp.lower()).cwiseMin(nlp.upper());
  return judge;
}

void RecedingHorizonController::fall_back(const VectorRef& state) {
  tick_.provenance = Provenance::fallback;
  fallback_ = options_.fallback_input;
  if (options_.fallback) {
    try {
      options_.fallback(now_, state, fallback_);
    } catch (...) {
      fallback_ = options_.fallback_input;
    }
    if (!fallback_.allFinite()) fallback_ = options_.fallback_input;
  }
  // Write the fallback into the plan, so that bounds and events are respected.
  const NonlinearProgram& nlp = shooting_->nlp();
  const Grid& grid = shooting_->grid();
  for (int j = 0; j < grid.phases(); ++j) {
    const PhaseDefinition& phase = shooting_->problem().phases()[j];
    const int nu = phase.sizes.nu;
    const int pieces = phase.input_shape() == InputShape::linear ? 2 : 1;
    for (int k = 0; k < grid.intervals(j); ++k)
      for (int i = 0; i < pieces * nu; ++i) {
        const double u = nu == fallback_.size() ? fallback_[i % nu] : 0.0;
        const int v = shooting_->layout().input(j, k) + i;
        guess_.w[v] = std::clamp(u / phase.nominal_input[i % nu], nlp.lower()[v], nlp.upper()[v]);
      }
    const int d = shooting_->layout().duration(j);
    if (d >= 0 && !std::isfinite(guess_.w[d])) guess_.w[d] = initial_.w[d];
  }
  hold(*shooting_, guess_.w, now_, options_.period, tick_.input);
}

double RecedingHorizonController::end_of_phase(int phase) const {
  if (const int phases = checked().grid().phases(); phase < 0 || phase >= phases)
    throw DefinitionError(
        fmt::format("controller: problem '{}' has {} phases, so there is no phase {}",
                    problem().name(), phases, phase));
  const NlpPoint& plan = is_of_this_tick(tick_.provenance) ? plan_ : guess_;
  return shooting_->program().start_of(phase + 1, &plan.w);
}

Solution RecedingHorizonController::report() {
  checked();
  const bool accepted = is_of_this_tick(tick_.provenance);
  NlpResult result;
  result.status = tick_.status;
  result.point = accepted ? plan_ : guess_;
  result.iterations = tick_.iterations;
  result.seconds = tick_.seconds;
  result.hessian = solver_->name();
  shooting_->nlp().objective(result.point.w.data(), result.objective);
  result.kkt = check_(shooting_->nlp(), result.point);
  if (result.status == SolveStatus::infeasible) {
    result.contradiction = presolve(shooting_->nlp(), result.point.w).contradiction;
    result.is_proved_infeasible =
        !result.contradiction && is_proved_infeasible(shooting_->nlp(), result.point.w);
  }
  const KktCheck::Residual kkt = result.kkt;
  double gain = 0.0;
  if (accepted && result.status == SolveStatus::optimal) {
    NonlinearProgram& nlp = shooting_->nlp();
    const Quantities quantities = undeclared_quantities(shooting_->program());
    ProgramSize size(nlp, quantities);
    // In a badly scaled program, a residual within its absolute tolerance does not prove an
    // optimum.
    if (size.look_at(result.point.w) &&
        !size.is_well_scaled_where_known({1.0, VectorXd::Ones(nlp.rows())}))
      gain = check_optimum(nlp, result.point, quantities).relative_gain();
    if (gain > doubtful_gain) result.status = SolveStatus::numerical_failure;
  }
  Solution solution = shooting_->interpret(std::move(result));
  if (gain > doubtful_gain)
    solution.message += fmt::format(
        "; the tick met its tolerance, but the cost may still decrease by {:.1e} of its magnitude: "
        "declare the magnitudes of states and inputs (nominal), or use a smaller tolerance",
        gain);
  if (measurement_ == Measurement::not_finite) {
    solution.message = "the measurement is not a number";
  } else if (measurement_ == Measurement::wrong_size) {
    solution.message = fmt::format("the measurement has {} entries, expected {}", measured_size_,
                                   shooting_->problem().phases().front().sizes.nx);
  }
  if (accepted && solution.status != SolveStatus::optimal)
    solution.message += fmt::format("; scaled KKT residual {:.3g}, largest violation {:.3g}",
                                    kkt.scaled(), kkt.feasibility);
  return solution;
}

}  // namespace saltus
