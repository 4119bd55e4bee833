#include "integrators/hybrid_integrator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace saltus {
namespace {

// Gaps between repetitions of an event that shrink by factors equal to this fraction ...
constexpr double regular_ratio = 0.1;
// ... this many times in a row are a geometric series. Its sum is the time of accumulation, at
// which integration stops when what is left is this fraction of the interval.
constexpr int regular_gaps = 4;
constexpr double left_of_interval = 1e-6;
// Events that may happen at one instant, one after the other.
constexpr int most_at_once = 16;
constexpr int most_projections = 20;
// Of the interval: how far ahead one looks where the rate of a guard is zero.
constexpr double a_little_later = 1e-4;

}  // namespace

const char* describe(EventKind kind) {
  switch (kind) {
    case EventKind::crosses:
      return "crosses";
    case EventKind::jumps:
      return "jumps";
    case EventKind::slides:
      return "slides";
    case EventKind::leaves:
      return "leaves";
  }
  return "unknown kind of event";
}

HybridIntegrator::HybridIntegrator(const IntervalProblem& definition,
                                   const MakeStepper& make_stepper)
    : Integrator(definition),
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

IntegrationStatus HybridIntegrator::run(const double* w, bool sensitivities) {
  const IntervalArguments place = arguments();
  sensitivities_ = sensitivities;
  t0_ = w[place.t0()];
  h_ = w[place.h()];
  s_ = 0.0;
  events_ = 0;
  modes_.load(w);
  stepper_->load(w);
  for (auto& of_mode : repetitions_) std::fill(of_mode.begin(), of_mode.end(), Repetition{});
  std::copy_n(w, states(), y_.begin());
  std::fill(y_.begin() + states(), y_.end(), 0.0);
  total_.setZero();
  for (int i = 0; i < states(); ++i) total_(i, i) = 1.0;
  std::fill(moving_.begin(), moving_.end(), 0.0);
  mode_ = 0;
  if (!all_finite(w, place.size())) return fail(IntegrationStatus::not_finite);
  if (h_ < 0.0) return fail(IntegrationStatus::backward);
  if (h_ == 0.0) {  // the identity; only the derivative with respect to h needs the field
    const IntegrationStatus status = choose_mode();
    if (status != IntegrationStatus::success) mode_ = 0;
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
  return status;
}

// --- the mode at the start ------------------------------------------------------------------

// Whether the mode fits the state, by its guards: sets sides_. Returns success, beyond_guard where
// a guard is crossed already, grazing where a guard is about to be crossed at this very instant,
// or ambiguous_start.
IntegrationStatus HybridIntegrator::judge_start(int mode) {
  const FlowMode& m = modes_[mode];
  guards_.sample(m, s_, y_.data(), samples_.data());
  IntegrationStatus verdict = IntegrationStatus::success;
  for (std::size_t k = 0; k < m.guards.size(); ++k) {
    const GuardSample& g = samples_[k];
    sides_[k] = GuardSide::inside;
    if (g.is_on()) {
      const bool tangent = g.is_tangent();
      if (tangent && !moves_away(mode, static_cast<int>(k)))
        return IntegrationStatus::ambiguous_start;
      sides_[k] = GuardSide::departing;
      if (!tangent && g.rate > 0.0) verdict = IntegrationStatus::grazing;
    } else if (!(g.value < 0.0)) {
      return IntegrationStatus::beyond_guard;
    }
  }
  return verdict;
}

// Where the rate of a guard is zero, its own rate decides: whether the motion leaves the guard into
// the mode.
bool HybridIntegrator::moves_away(int mode, int guard) {
  const FlowMode& m = modes_[mode];
  m.field->argument(s_, y_.data(), z_.data());
  m.field->value(z_.data(), phi_.data());
  for (int r = 0; r < outputs(); ++r) ahead_[r] = y_[r] + a_little_later * h_ * phi_[r];
  const GuardSample later = guards_.sample(m, guard, s_ + a_little_later, ahead_.data());
  return later.rate < 0.0 && !later.is_tangent();
}

// First a mode inside all its guards, or on one of them and moving away from it; then one that has
// an event at this very instant; then one behind a guard to which it returns (a shooting node just
// behind the reset of the event before it).
IntegrationStatus HybridIntegrator::choose_mode() {
  if (given_mode_ >= modes_.declared()) {  // sliding goes on
    mode_ = given_mode_;
    return settle(false, -1, false, -1);
  }
  const int first = std::max(given_mode_, 0);
  const int last = given_mode_ >= 0 ? given_mode_ : modes_.declared() - 1;
  bool tangent = false;
  int tangent_mode = first;
  for (int m = first; m <= last; ++m) {
    const IntegrationStatus verdict = judge_start(m);
    if (verdict == IntegrationStatus::ambiguous_start) {
      tangent = true;
      tangent_mode = m;
    }
    if (verdict != IntegrationStatus::success) continue;
    mode_ = m;
    for (std::size_t k = 0; k < modes_[m].guards.size(); ++k) {
      const OutgoingGuard& guard = modes_[m].guards[k];
      if (sides_[k] != GuardSide::departing || guard.partner < 0) continue;
      const GuardSample other = guards_.sample(modes_[guard.target], guard.partner, s_, y_.data());
      if (other.is_tangent()) return fail(IntegrationStatus::ambiguous_start, static_cast<int>(k));
      if (other.rate < 0.0) return fail(IntegrationStatus::non_unique, static_cast<int>(k));
    }
    return IntegrationStatus::success;
  }
  for (int m = first; m <= last; ++m) {
    if (judge_start(m) != IntegrationStatus::grazing) continue;
    mode_ = m;
    return settle(false, -1, false, -1);
  }
  if (tangent) {
    mode_ = tangent_mode;
    return fail(IntegrationStatus::ambiguous_start);
  }
  for (int m = first; m <= last; ++m) {
    guards_.sample(modes_[m], s_, y_.data(), samples_.data());
    bool returns = true;
    for (std::size_t k = 0; k < modes_[m].guards.size(); ++k) {
      const GuardSample& g = samples_[k];
      sides_[k] = g.value < 0.0 ? GuardSide::inside : GuardSide::returning;
      if (sides_[k] == GuardSide::returning && !(g.rate < 0.0 && !g.is_tangent())) returns = false;
    }
    if (!returns) continue;
    mode_ = m;
    return IntegrationStatus::success;
  }
  mode_ = first;
  return fail(IntegrationStatus::beyond_guard);
}

// --- between events -------------------------------------------------------------------------

IntegrationStatus HybridIntegrator::flow(bool& finished) {
  const FlowMode& mode = modes_[mode_];
  locator_.begin(mode, sides_, s_, y_.data());
  IntegrationStatus status =
      stepper_->begin(*mode.field, s_, y_.data(), sensitivities_ ? &total_ : nullptr,
                      sensitivities_ ? moving_.data() : nullptr);
  if (status != IntegrationStatus::success) return fail(status);
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
    if (sensitivities_) {
      total_ = held_;
      std::fill(moving_.begin(), moving_.end(), 0.0);
    }
    if (mode.surface) {
      status = project();
      if (status != IntegrationStatus::success) return status;
    }
    finished = reached >= 1.0;
    // A sliding step of a one-step scheme: onto the surface, and on from there.
    if (!finished) std::fill_n(sides_.begin(), mode.guards.size(), GuardSide::inside);
    return IntegrationStatus::success;
  }
}

// Back onto the surface of a sliding mode, along the state that moves the guard most; the
// derivative is that of the implicit function.
IntegrationStatus HybridIntegrator::project() {
  const FlowMode& mode = modes_[mode_];
  const SparsityPattern& pattern = mode.surface.jacobian_pattern();
  const Arguments& sizes = problem().arguments;
  int chosen = -1, entry = -1;
  double g = 0.0;
  for (int i = 0; i < most_projections; ++i) {
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

// The event of a guard at s_, with y_, and held_ and slope_ before it.
IntegrationStatus HybridIntegrator::fire(int k) {
  const FlowMode& mode = modes_[mode_];
  const OutgoingGuard& guard = mode.guards[k];
  const IntervalField& field = *mode.field;
  if (++events_ > most_events) return fail(IntegrationStatus::accumulation, k);
  const GuardSample sample = guards_.sample(mode, k, s_, y_.data());
  if (!(sample.rate > 0.0) || sample.is_tangent()) return fail(IntegrationStatus::grazing, k);
  const IntegrationStatus repeated = watch_accumulation(guard);
  if (repeated != IntegrationStatus::success) return fail(repeated, k);

  field.argument(s_, y_.data(), z_.data());
  if (sensitivities_) {
    double g = 0.0;
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
  }
  HybridEvent* event = nullptr;
  if (recorded_ != nullptr) {
    event = &recorded_->emplace_back();
    event->time = time_at(s_);
    event->name = guard.name;
    event->mode_before = mode.name;
    event->mode_after = modes_[guard.target].name;
    event->kind = guard.reset          ? EventKind::jumps
                  : guard.ends_sliding ? EventKind::leaves
                                       : EventKind::crosses;
    event->before = Eigen::Map<const VectorXd>(y_.data(), states());
    if (sensitivities_) {  // t = t0 + s h
      const IntervalArguments place = arguments();
      event->time_derivative = VectorXd::Zero(place.size());
      for (std::size_t d = 0; d < moving_.size(); ++d)
        event->time_derivative[field.column(static_cast<int>(d))] = h_ * moving_[d];
      if (field.differentiates_time()) {
        event->time_derivative[place.t0()] += 1.0;
        event->time_derivative[place.h()] += s_;
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
  const int came_from = mode_;
  mode_ = guard.target;
  const bool same = came_from == mode_;
  return settle(static_cast<bool>(guard.reset), guard.partner, guard.ends_sliding, same ? k : -1);
}

// After a jump or at the start: what the guards of mode_ say at this instant. `partner` is the
// guard on whose surface the state is for certain, `fired` one that must not fire at once again.
IntegrationStatus HybridIntegrator::settle(bool after_jump, int partner, bool left_sliding,
                                           int fired) {
  for (int hops = 0; hops <= most_at_once; ++hops) {
    const FlowMode& mode = modes_[mode_];
    guards_.sample(mode, s_, y_.data(), samples_.data());
    int now = -1;
    bool moved = false;
    for (std::size_t i = 0; i < mode.guards.size() && !moved; ++i) {
      const int k = static_cast<int>(i);
      const OutgoingGuard& guard = mode.guards[k];
      const GuardSample& g = samples_[k];
      if (!std::isfinite(g.value)) return fail(IntegrationStatus::not_finite, k);
      sides_[k] = GuardSide::inside;
      if (k == partner && left_sliding) {
        sides_[k] = GuardSide::departing;
      } else if (k == partner || g.is_on()) {
        sides_[k] = GuardSide::departing;
        bool pushes = g.rate > 0.0;
        if (g.is_tangent()) {  // at the edge of sliding, sliding decides
          pushes = k == partner && guard.slide >= 0;
          if (!pushes && !moves_away(mode_, k)) return fail(IntegrationStatus::ambiguous_start, k);
        }
        if (pushes && now < 0) now = k;
      } else if (g.value > 0.0) {
        // Behind a surface that divides two fields the other field holds.
        if (!after_jump || guard.partner < 0) return fail(IntegrationStatus::beyond_guard, k);
        mode_ = guard.target;
        partner = fired = -1;
        moved = true;
      }
    }
    if (moved) continue;
    if (now < 0) return IntegrationStatus::success;
    if (now == partner && mode.guards[now].slide >= 0) return enter_sliding(now);
    if (now == fired) return fail(IntegrationStatus::beyond_guard, now);
    hold_instant();
    return fire(now);
  }
  return fail(IntegrationStatus::accumulation);
}

IntegrationStatus HybridIntegrator::enter_sliding(int k) {
  mode_ = modes_[mode_].guards[k].slide;
  const FlowMode& mode = modes_[mode_];
  if (mode.unsupported) return fail(IntegrationStatus::sliding_input);
  if (recorded_ != nullptr && !recorded_->empty()) {
    recorded_->back().kind = EventKind::slides;
    recorded_->back().mode_after = mode.name;
  }
  return settle(false, -1, false, -1);
}

// held_ and slope_ at s_ from total_ and moving_, in the field of mode_.
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

// Gaps between repetitions of one event that form a geometric series have an end.
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
  if (left > left_of_interval || s_ + left >= 1.0) return IntegrationStatus::success;
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

}  // namespace saltus
