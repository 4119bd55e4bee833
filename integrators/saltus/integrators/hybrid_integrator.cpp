#include "saltus/integrators/hybrid_integrator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

// Events accumulate if the gaps between repetitions of an event form a geometric series: they
// shrink by factors that agree to regular_ratio, regular_gaps times in a row. The sum of the series
// is the time of accumulation. Integration stops when the remaining time to it is
// remaining_fraction of the interval.
constexpr double regular_ratio = 0.1;
constexpr int regular_gaps = 4;
constexpr double remaining_fraction = 1e-6;
constexpr int max_projections = 20;

// Sets a value for the lifetime of this object, also if a formula throws.
template <class T>
class ScopedValue {
 public:
  ScopedValue(T& variable, T value)
      : variable_(variable), before_(std::exchange(variable, value)) {}
  ~ScopedValue() { variable_ = before_; }
  ScopedValue(const ScopedValue&) = delete;
  ScopedValue& operator=(const ScopedValue&) = delete;

 private:
  T& variable_;
  T before_;
};

}  // namespace

HybridIntegrator::HybridIntegrator(const IntervalProblem& definition,
                                   const MakeStepper& make_stepper,
                                   const std::optional<OneStepScheme>& scheme)
    : EventIntegrator(definition),
      modes_(problem()),
      guards_(problem(), modes_),
      stepper_(make_stepper(problem(), modes_)),
      locator_(*stepper_, guards_, outputs(), modes_.largest_guard_count()),
      sides_(modes_.largest_guard_count()),
      samples_(modes_.largest_guard_count()),
      y_(outputs()),
      ahead_(outputs()),
      slope_(outputs()),
      z_(problem().arguments.size()),
      phi_(outputs()),
      entries_(modes_.largest_entry_count()),
      reset_slope_(outputs()),
      guard_slope_(1) {
  const int directions = modes_[0].field->directions();
  moving_.resize(directions);
  total_.resize(outputs(), directions);
  held_.resize(outputs(), directions);
  guard_row_.resize(1, directions);
  reset_rows_.resize(states(), directions);
  for (int m = 0; m < modes_.count(); ++m) repetitions_.emplace_back(modes_[m].guards.size());
  if (!scheme || modes_.count() > modes_.declared()) return;  // sliding has first derivatives only
  curvature_.emplace(problem(), modes_, *scheme);
  second_.resize(directions, directions);
  weights_.resize(outputs());
}

IntegrationStatus HybridIntegrator::value(const double* w, double* end) {
  const IntegrationStatus status = run(w, false);
  std::copy(y_.begin(), y_.end(), end);
  return status;
}

IntegrationStatus HybridIntegrator::jacobian(const double* w, double* end, MatrixXd& derivative) {
  const IntegrationStatus status = run(w, true);
  std::copy(y_.begin(), y_.end(), end);
  if (status != IntegrationStatus::success) return status;
  modes_[mode_].field->scatter(total_, derivative);
  return all_finite(total_.data(), static_cast<int>(total_.size()))
             ? status
             : fail(IntegrationStatus::not_finite);
}

IntegrationStatus HybridIntegrator::hessian(const double* w, const double* weights,
                                            MatrixXd& hessian, Curvature curvature) {
  if (!has_hessian()) return IntegrationStatus::library_failure;
  const IntegrationStatus status = record_run(w);
  return status == IntegrationStatus::success ? second_order(weights, hessian, curvature) : status;
}

IntegrationStatus HybridIntegrator::derivatives(const double* w, const double* weights, double* end,
                                                MatrixXd& derivative, MatrixXd& hessian,
                                                Curvature curvature) {
  if (!has_hessian()) return IntegrationStatus::library_failure;
  const IntegrationStatus status = record_run(w);
  std::copy(y_.begin(), y_.end(), end);
  if (status != IntegrationStatus::success) return status;
  modes_[mode_].field->scatter(total_, derivative);
  return second_order(weights, hessian, curvature);
}

IntegrationStatus HybridIntegrator::record_run(const double* w) {
  tape_.clear();
  const ScopedValue taping(taping_, true);
  return run(w, true);
}

IntegrationStatus HybridIntegrator::second_order(const double* weights, MatrixXd& hessian,
                                                 Curvature curvature) {
  std::copy_n(weights, outputs(), weights_.data());
  if (remembered_) weights_[problem().switching.memory] = 0.0;
  const IntegrationStatus status = curvature_->hessian(tape_, weights_, curvature, second_);
  if (status != IntegrationStatus::success) return fail(status);
  modes_[mode_].field->scatter_symmetric(second_, hessian);
  return status;
}

IntegrationStatus HybridIntegrator::run(const double* w, bool sensitivities) {
  const IntervalArguments index = arguments();
  sensitivities_ = sensitivities;
  t0_ = w[index.t0()];
  h_ = w[index.h()];
  s_ = 0.0;
  modes_.load(w);
  stepper_->load(w);
  for (auto& of_mode : repetitions_) std::fill(of_mode.begin(), of_mode.end(), Repetition{});
  reset_to_start(w);
  guards_.begin(y_.data());
  mode_ = 0;
  if (!all_finite(w, index.size())) return fail(IntegrationStatus::not_finite);
  if (h_ < 0.0) return fail(IntegrationStatus::backward);
  if (h_ == 0.0) {  // the identity; only the derivative with respect to h needs the field
    // Events at this instant belong to the next interval.
    {
      const ScopedValue unrecorded(recorded_, static_cast<std::vector<HybridEvent>*>(nullptr));
      if (choose_mode() != IntegrationStatus::success) mode_ = 0;
    }
    reset_to_start(w);
    if (taping_) {
      tape_.clear();
      record_flow();
      tape_.back().end = 1.0;
    }
    const IntervalField& field = *modes_[mode_].field;
    if (sensitivities && field.differentiates_time()) {
      field.argument(0.0, y_.data(), z_.data());
      field.value(z_.data(), phi_.data());
      for (int r = 0; r < outputs(); ++r) total_(r, field.h_direction()) = phi_[r];
    }
    return IntegrationStatus::success;
  }
  IntegrationStatus status = choose_mode();
  for (bool finished = false; status == IntegrationStatus::success && !finished;)
    status = flow(finished);
  if (status == IntegrationStatus::success) remember();
  return status;
}

void HybridIntegrator::reset_to_start(const double* w) {
  events_ = 0;
  remembered_ = false;
  std::copy_n(w, states(), y_.begin());
  std::fill(y_.begin() + states(), y_.end(), 0.0);
  total_.setZero();
  for (int i = 0; i < states(); ++i) total_(i, i) = 1.0;
  std::fill(moving_.begin(), moving_.end(), 0.0);
}

// Sets the state that stores the mode after events changed it. Its derivative is zero.
void HybridIntegrator::remember() {
  const int memory = problem().switching.memory;
  remembered_ = memory >= 0 && (events_ > 0 || mode_ != std::lround(y_[memory]));
  if (!remembered_) return;
  y_[memory] = mode_;
  if (sensitivities_) total_.row(memory).setZero();
}

void HybridIntegrator::record_flow() {
  if (!taping_) return;
  HybridPiece& piece = tape_.add();
  piece.mode = mode_;
  piece.guard = -1;
  piece.begin = piece.end = s_;
  piece.state = Eigen::Map<const VectorXd>(y_.data(), outputs());
  piece.total = total_;
  piece.begin_moves = Eigen::Map<const VectorXd>(moving_.data(), total_.cols());
  piece.end_moves = VectorXd::Zero(total_.cols());
}

// Records the event of a guard of mode_ at s_, which ends the previous flow.
void HybridIntegrator::record_event(int k, bool located, double rate) {
  if (!taping_) return;
  if (located) {
    tape_.back().end = s_;
    tape_.back().end_moves = Eigen::Map<const VectorXd>(moving_.data(), total_.cols());
  }
  record_flow();  // fields in common with a flow
  HybridPiece& piece = tape_.back();
  piece.guard = k;
  piece.located = located;
  piece.rate = rate;
  piece.slope = Eigen::Map<const VectorXd>(slope_.data(), outputs());
}

// --- between events -------------------------------------------------------------------------

IntegrationStatus HybridIntegrator::flow(bool& finished) {
  const FlowMode& mode = modes_[mode_];
  locator_.begin(mode, sides_, s_, y_.data());
  IntegrationStatus status =
      stepper_->begin(*mode.field, s_, y_.data(), sensitivities_ ? &total_ : nullptr,
                      sensitivities_ ? moving_.data() : nullptr);
  if (status != IntegrationStatus::success) return fail(status);
  record_flow();
  for (;;) {
    if (s_ < 1.0) {
      status = stepper_->step();
      if (status != IntegrationStatus::success) {
        s_ = stepper_->step_end();
        return fail(status);
      }
    }
    const LocatedCrossing found = s_ < 1.0 ? locator_.search() : LocatedCrossing{};
    const bool event = found.guard >= 0 && found.status == IntegrationStatus::success;
    const double reached = found.guard >= 0 ? found.s : s_ < 1.0 ? stepper_->step_end() : s_;
    const bool restart = mode.surface && stepper_->restarts_freely();
    if (!event && found.status == IntegrationStatus::success && reached < 1.0 && !restart) {
      s_ = reached;
      continue;
    }
    s_ = reached;
    if (found.status != IntegrationStatus::success) return fail(found.status, found.guard);
    stepper_->state_at(s_, y_.data());
    if (!all_finite(y_.data(), outputs())) return fail(IntegrationStatus::not_finite);
    if (sensitivities_) {
      status = stepper_->sensitivity_at(s_, held_, slope_.data());
      if (status != IntegrationStatus::success) return fail(status);
    }
    if (event) return fire(found.guard);
    if (taping_) tape_.back().end = s_;
    if (sensitivities_) {
      total_ = held_;
      std::fill(moving_.begin(), moving_.end(), 0.0);
    }
    if (mode.surface) {
      status = project();
      if (status != IntegrationStatus::success) return status;
    }
    finished = reached >= 1.0;
    // After a sliding step of a one-step scheme: project onto the surface and continue.
    if (!finished) std::fill_n(sides_.begin(), mode.guards.size(), GuardSide::inside);
    return IntegrationStatus::success;
  }
}

// Projects onto the surface of a sliding mode along the state that changes the guard most. The
// derivative follows from the implicit function theorem.
IntegrationStatus HybridIntegrator::project() {
  const FlowMode& mode = modes_[mode_];
  const SparsityPattern& pattern = mode.surface.jacobian_pattern();
  const Arguments& sizes = problem().arguments;
  int chosen = -1, entry = -1;
  double g = 0.0;
  for (int i = 0; i < max_projections; ++i) {
    mode.field->argument(s_, y_.data(), z_.data());
    mode.surface.jacobian(z_.data(), &g, entries_.data());
    double rounding = 0.0, largest = 0.0;
    for (int e = 0; e < pattern.entries(); ++e) {
      const int state = pattern.col(e) - sizes.x();
      rounding += 1e-16 * std::abs(entries_[e] * z_[pattern.col(e)]);
      if (state < 0 || state >= sizes.nx || i > 0) continue;
      const double nominal =
          problem().nominal_state.size() > 0 ? problem().nominal_state[state] : 1.0;
      if (std::abs(entries_[e]) * nominal <= largest) continue;
      largest = std::abs(entries_[e]) * nominal;
      chosen = state;
      entry = e;
    }
    if (chosen < 0 || !std::isfinite(g)) return fail(IntegrationStatus::not_finite);
    if (std::abs(g) <= rounding) break;
    const double change = g / entries_[entry];
    if (y_[chosen] - change == y_[chosen]) break;
    y_[chosen] -= change;
  }
  if (!sensitivities_) return IntegrationStatus::success;
  mode.field->differential(pattern, entries_.data(), s_, total_, guard_row_);
  for (int d = 0; d < total_.cols(); ++d) total_(chosen, d) -= guard_row_(0, d) / entries_[entry];
  return IntegrationStatus::success;
}

// --- events ---------------------------------------------------------------------------------

// Fires the event of a guard at s_ with y_; held_ and slope_ are those before it.
IntegrationStatus HybridIntegrator::fire(int k) {
  const FlowMode& mode = modes_[mode_];
  const OutgoingGuard& guard = mode.guards[k];
  const IntervalField& field = *mode.field;
  const GuardSample sample = guards_.sample(mode, k, s_, y_.data());
  if (!(sample.rate > 0.0) || sample.is_tangent()) return fail(IntegrationStatus::grazing, k);
  const IntegrationStatus repeated = watch_accumulation(guard);
  if (repeated != IntegrationStatus::success) return fail(repeated, k);

  if (sensitivities_) {
    double g = 0.0;
    field.argument(s_, y_.data(), z_.data());
    const SparsityPattern& pattern = guard.function.jacobian_pattern();
    guard.function.jacobian(z_.data(), &g, entries_.data());
    field.differential(pattern, entries_.data(), s_, held_, guard_row_);
    field.explicit_slope(pattern, entries_.data(), guard_slope_.data());
    double rate = guard_slope_[0];
    for (int e = 0; e < pattern.entries(); ++e) {
      const int state = pattern.col(e) - problem().arguments.x();
      if (state >= 0 && state < states()) rate += entries_[e] * slope_[state];
    }
    for (std::size_t d = 0; d < moving_.size(); ++d) moving_[d] = -guard_row_(0, d) / rate;
    for (int r = 0; r < outputs(); ++r)
      for (std::size_t d = 0; d < moving_.size(); ++d)
        total_(r, d) = held_(r, d) + slope_[r] * moving_[d];
    record_event(k, true, rate);
  }
  const int came_from = mode_;
  const IntegrationStatus passed = pass(k);
  if (passed != IntegrationStatus::success) return passed;
  const bool same = came_from == mode_;
  return settle(static_cast<bool>(guard.reset), guard.partner, guard.ends_sliding, same ? k : -1);
}

// Passes through the guard into the next mode at s_ with y_, total_ and moving_: records the event
// and applies the reset.
IntegrationStatus HybridIntegrator::pass(int k) {
  const FlowMode& mode = modes_[mode_];
  const OutgoingGuard& guard = mode.guards[k];
  const IntervalField& field = *mode.field;
  if (++events_ > max_events) return fail(IntegrationStatus::accumulation, k);
  field.argument(s_, y_.data(), z_.data());
  HybridEvent* event = nullptr;
  if (recorded_ != nullptr) {
    event = &recorded_->emplace_back();
    event->time = time_at(s_);
    event->name = guard.name;
    event->mode_before = mode.name;
    event->mode_after = modes_[guard.target].name;
    event->kind = guard.reset          ? HybridEvent::Kind::jumps
                  : guard.ends_sliding ? HybridEvent::Kind::leaves
                                       : HybridEvent::Kind::crosses;
    event->before = Eigen::Map<const VectorXd>(y_.data(), states());
    if (sensitivities_) {  // t = t0 + s h
      const IntervalArguments index = arguments();
      event->time_derivative = VectorXd::Zero(index.size());
      for (std::size_t d = 0; d < moving_.size(); ++d)
        event->time_derivative[field.column(static_cast<int>(d))] = h_ * moving_[d];
      if (field.differentiates_time()) {
        event->time_derivative[index.t0()] += 1.0;
        event->time_derivative[index.h()] += s_;
      }
    }
  }
  if (guard.reset) {
    const SparsityPattern& pattern = guard.reset.jacobian_pattern();
    guard.reset.jacobian(z_.data(), y_.data(), entries_.data());
    if (!all_finite(y_.data(), states())) return fail(IntegrationStatus::not_finite, k);
    if (sensitivities_) {
      field.differential(pattern, entries_.data(), s_, total_, reset_rows_);
      field.explicit_slope(pattern, entries_.data(), reset_slope_.data());
      for (int r = 0; r < states(); ++r)
        for (std::size_t d = 0; d < moving_.size(); ++d)
          total_(r, d) = reset_rows_(r, d) + reset_slope_[r] * moving_[d];
    }
  }
  if (event != nullptr) event->after = Eigen::Map<const VectorXd>(y_.data(), states());
  mode_ = guard.target;
  return IntegrationStatus::success;
}

// Computes held_ and slope_ at s_ from total_ and moving_ in the field of mode_.
void HybridIntegrator::hold_instant() {
  if (!sensitivities_) return;
  const IntervalField& field = *modes_[mode_].field;
  field.argument(s_, y_.data(), z_.data());
  field.value(z_.data(), phi_.data());
  for (int r = 0; r < outputs(); ++r) {
    slope_[r] = h_ * phi_[r];
    for (std::size_t d = 0; d < moving_.size(); ++d)
      held_(r, d) = total_(r, d) - slope_[r] * moving_[d];
  }
}

// Detects gaps between repetitions of an event that form a geometric series and thus accumulate.
IntegrationStatus HybridIntegrator::watch_accumulation(const OutgoingGuard& guard) {
  const FlowMode& mode = modes_[mode_];
  Repetition& r = repetitions_[mode_][&guard - mode.guards.data()];
  const double gap = s_ - r.last, ratio = gap / r.gap;
  if (r.last >= 0.0 && r.gap > 0.0) {
    const bool shrinks = ratio < 1.0;
    r.regular = shrinks && std::abs(ratio - r.ratio) <= regular_ratio * ratio ? r.regular + 1 : 0;
    r.ratio = ratio;
  }
  if (r.last >= 0.0) r.gap = gap;
  r.last = s_;
  if (r.regular < regular_gaps) return IntegrationStatus::success;
  const double left = gap * ratio / (1.0 - ratio);
  if (left > remaining_fraction || s_ + left >= 1.0) return IntegrationStatus::success;
  s_ += left;
  return IntegrationStatus::accumulation;
}

IntegrationStatus HybridIntegrator::fail(IntegrationStatus status, int guard) {
  failure_ = {status, time_at(s_), mode_, guard};
  return status;
}

std::string HybridIntegrator::failure() const {
  if (failure_.status == IntegrationStatus::success) return {};
  char time[32];
  std::snprintf(time, sizeof time, "%.9g", failure_.time);
  const FlowMode& mode = modes_[failure_.mode];
  std::string text = std::string("at t = ") + time + " s in mode '" + mode.name + "'";
  if (failure_.guard >= 0) text += ", event '" + mode.guards[failure_.guard].name + "'";
  return text + ": " + saltus::describe(failure_.status);
}

void throw_no_event_support(const IntervalProblem& problem, const char* scheme) {
  if (problem.switching.empty()) return;
  throw DefinitionError(
      fmt::format("{} does not handle event '{}' inside an interval; use cvodes, idas or a "
                  "Runge-Kutta scheme, or make the event the end of a phase.",
                  scheme, problem.switching.transitions.front().name));
}

}  // namespace saltus
