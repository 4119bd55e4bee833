// Determines the active mode at an instant: at the start of an interval and after an event.
#include "saltus/integrators/hybrid_integrator.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

// Maximum number of consecutive events at one instant.
constexpr int max_simultaneous_events = 16;
// Look-ahead, as a fraction of the interval, where the rate of a guard is zero.
constexpr double look_ahead = 1e-4;

}  // namespace

// Checks by its guards whether the mode fits the state, and sets sides_. Returns success, or
// beyond_guard if a guard is crossed already. Returns grazing if a guard is crossed at this
// instant, or ambiguous_start.
IntegrationStatus HybridIntegrator::judge_start(int mode) {
  const FlowMode& m = modes_[mode];
  guards_.sample(m, s_, y_.data(), samples_.data());
  IntegrationStatus verdict = IntegrationStatus::success;
  for (std::size_t k = 0; k < m.guards.size(); ++k) {
    const GuardSample& g = samples_[k];
    sides_[k] = GuardSide::inside;
    if (g.is_on()) {
      const bool tangent = g.is_tangent();
      if (tangent && !leaves_guard(mode, static_cast<int>(k)))
        return IntegrationStatus::ambiguous_start;
      sides_[k] = GuardSide::departing;
      if (!tangent && g.rate > 0.0) verdict = IntegrationStatus::grazing;
    } else if (!(g.value < 0.0)) {
      return IntegrationStatus::beyond_guard;
    }
  }
  return verdict;
}

// If the rate of a guard is zero, the rate slightly later decides whether the trajectory moves away
// from the guard into the mode.
bool HybridIntegrator::leaves_guard(int mode, int guard) {
  const FlowMode& m = modes_[mode];
  m.field->argument(s_, y_.data(), z_.data());
  m.field->value(z_.data(), phi_.data());
  for (int r = 0; r < outputs(); ++r) ahead_[r] = y_[r] + look_ahead * h_ * phi_[r];
  const GuardSample later = guards_.sample(m, guard, s_ + look_ahead, ahead_.data());
  return later.rate < 0.0 && !later.is_tangent();
}

// True if the state is on the surface of a sliding mode, whose first guard leads to an adjacent
// mode. Parameters and inputs may have moved the surface since the last interval.
bool HybridIntegrator::is_on_surface(int sliding) {
  const OutgoingGuard& leave = modes_[sliding].guards.front();
  return guards_.sample(modes_[leave.target], leave.partner, s_, y_.data()).is_on();
}

// Order of preference: first a mode inside all its guards, or on one of them and moving away. Then
// a mode with an event at this instant. Then a mode beyond a guard to which it returns, as for a
// shooting node just beyond a reset. Last, if the mode is given, its overdue event.
IntegrationStatus HybridIntegrator::choose_mode() {
  int given = given_mode_;
  if (const int memory = problem().switching.memory; memory >= 0)
    given = std::clamp(static_cast<int>(std::lround(y_[memory])), 0, modes_.declared() - 1);
  if (given >= modes_.declared()) {
    mode_ = given;
    if (is_on_surface(given)) return settle(false, -1, false, -1);  // sliding continues
    given = -1;
  }
  const int first = std::max(given, 0);
  const int last = given >= 0 ? given : modes_.declared() - 1;
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
      if (sides_[k] == GuardSide::inside) continue;
      returns = returns && std::isfinite(g.value) && g.rate < 0.0 && !g.is_tangent();
    }
    if (!returns) continue;
    mode_ = m;
    return IntegrationStatus::success;
  }
  mode_ = first;
  if (given >= 0 && h_ == 0.0) return IntegrationStatus::success;  // no event without passing time
  return given >= 0 ? fire_overdue_event() : fail(IntegrationStatus::beyond_guard);
}

// Since the last interval, a parameter, an input or a disturbance moved a guard of the given mode_
// past the state. Its event fires at the start of the interval, wherever the guard is now. The
// event time therefore does not vary.
IntegrationStatus HybridIntegrator::fire_overdue_event() {
  for (int hops = 0; hops <= max_simultaneous_events; ++hops) {
    const IntegrationStatus verdict = judge_start(mode_);
    if (verdict == IntegrationStatus::grazing) return settle(false, -1, false, -1);
    if (verdict != IntegrationStatus::beyond_guard)
      return verdict == IntegrationStatus::success ? verdict : fail(verdict);
    const FlowMode& mode = modes_[mode_];
    int crossed = -1;
    bool returns = true;
    for (int k = static_cast<int>(mode.guards.size()) - 1; k >= 0; --k) {
      const GuardSample& g = samples_[k];
      if (!std::isfinite(g.value)) return fail(IntegrationStatus::not_finite, k);
      sides_[k] = g.value < 0.0 ? GuardSide::inside : GuardSide::returning;
      if (sides_[k] == GuardSide::inside || g.is_on()) continue;
      crossed = k;
      returns = returns && g.rate < 0.0 && !g.is_tangent();
    }
    if (returns) return IntegrationStatus::success;
    std::fill(moving_.begin(), moving_.end(), 0.0);
    record_event(crossed, false, 0.0);
    const IntegrationStatus passed = pass(crossed);
    if (passed != IntegrationStatus::success) return passed;
  }
  return fail(IntegrationStatus::accumulation);
}

// Resolves the guards of mode_ at this instant, after a jump or at the start. The state is exactly
// on the surface of guard `partner`. Guard `fired` must not fire again at this instant.
IntegrationStatus HybridIntegrator::settle(bool after_jump, int partner, bool left_sliding,
                                           int fired) {
  for (int hops = 0; hops <= max_simultaneous_events; ++hops) {
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
        if (g.is_tangent()) {  // at the edge of sliding, sliding has precedence
          pushes = k == partner && guard.slide >= 0;
          if (!pushes && !leaves_guard(mode_, k))
            return fail(IntegrationStatus::ambiguous_start, k);
        }
        if (pushes && now < 0) now = k;
      } else if (g.value > 0.0) {
        // Beyond a surface between two fields, the other field is active.
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
    record_flow();  // flow of zero length
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
    recorded_->back().kind = HybridEvent::Kind::slides;
    recorded_->back().mode_after = mode.name;
  }
  return settle(false, -1, false, -1);
}

}  // namespace saltus
