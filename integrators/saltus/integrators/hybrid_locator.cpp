#include "saltus/integrators/hybrid_locator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace saltus {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// A zero of f in [a, b] with fa and fb of different sign, to rounding of s. Uses the Illinois
// variant of regula falsi, with a bisection whenever three steps do not halve the bracket.
template <class F>
double zero(F&& f, double a, double fa, double b, double fb) {
  if (fa == 0.0) return a;
  if (fb == 0.0) return b;
  constexpr int most_iterations = 100;  // bisection alone needs 53
  const double first_a = a, first_b = b;
  double best = std::abs(fa) < std::abs(fb) ? a : b;
  double best_value = std::min(std::abs(fa), std::abs(fb));
  double width = b - a;
  for (int i = 0; i < most_iterations && b - a > epsilon * std::max(std::abs(a), std::abs(b));
       ++i) {
    double c = b - fb * (b - a) / (fb - fa);
    if (i % 3 == 2) {
      if (b - a > 0.5 * width) c = 0.5 * (a + b);
      width = b - a;
    }
    if (!(c > a && c < b)) c = 0.5 * (a + b);
    if (c == a || c == b) break;
    const double fc = f(c);
    if (std::abs(fc) < best_value) {
      best = c;
      best_value = std::abs(fc);
    }
    if (fc == 0.0) return c;
    if ((fc > 0.0) == (fb > 0.0)) {
      b = c;
      fb = fc;
      fa *= 0.5;
    } else {
      a = c;
      fa = fc;
      fb *= 0.5;
    }
  }
  return std::clamp(best, first_a, first_b);
}

}  // namespace

EventLocator::EventLocator(FlowStepper& stepper, GuardEvaluator& guards, int states_and_costs,
                           int most_guards)
    : stepper_(stepper),
      guards_(guards),
      y_(states_and_costs),
      sides_(most_guards),
      before_(most_guards),
      after_(most_guards) {}

void EventLocator::begin(const FlowMode& mode, const std::vector<GuardSide>& sides, double s,
                         const double* x) {
  mode_ = &mode;
  std::copy_n(sides.begin(), mode.guards.size(), sides_.begin());
  guards_.begin(x);
  guards_.sample(mode, s, x, before_.data());
}

GuardSample EventLocator::at(int k, double s) {
  stepper_.state_at(s, y_.data());
  return guards_.sample(*mode_, k, s, y_.data());
}

double EventLocator::crossing(int k, double a, double b) {
  return zero([&](double s) { return at(k, s).value; }, a, at(k, a).value, b, at(k, b).value);
}

double EventLocator::turning_point(int k, double a, double b) {
  return zero([&](double s) { return at(k, s).rate; }, a, before_[k].rate, b, after_[k].rate);
}

LocatedCrossing EventLocator::search() {
  const double start = stepper_.step_start(), end = stepper_.step_end();
  const int parts = stepper_.parts_per_step();
  double a = start;
  for (int i = 1; i <= parts; ++i) {
    const double b = i == parts ? end : start + (end - start) * i / parts;
    stepper_.state_at(b, y_.data());
    guards_.sample(*mode_, b, y_.data(), after_.data());
    const LocatedCrossing found = search_part(a, b);
    if (found.status != IntegrationStatus::success || found.guard >= 0) return found;
    stepper_.state_at(b, y_.data());  // the search may have evaluated another point last
    guards_.pass(y_.data());
    std::swap(before_, after_);
    a = b;
  }
  return {};
}

LocatedCrossing EventLocator::search_part(double a, double b) {
  LocatedCrossing first;
  for (std::size_t k = 0; k < mode_->guards.size(); ++k) {
    const LocatedCrossing found = search_guard(static_cast<int>(k), a, b);
    // A failure counts only before the first event: after it, another mode is active.
    if (found.guard >= 0 && (first.guard < 0 || found.s < first.s)) first = found;
  }
  return first;
}

LocatedCrossing EventLocator::search_guard(int k, double a, double b) {
  const GuardSample &start = before_[k], &end = after_[k];
  const LocatedCrossing none;
  const auto crossed = [&](double s) { return LocatedCrossing{IntegrationStatus::success, k, s}; };
  const auto fail = [&](IntegrationStatus status, double s) {
    return LocatedCrossing{status, k, s};
  };
  if (!std::isfinite(end.value) || !std::isfinite(end.rate))
    return fail(IntegrationStatus::not_finite, b);
  const bool is_end = b >= 1.0;

  if (sides_[k] != GuardSide::inside) {
    if (end.value < -end.rounding) {
      sides_[k] = GuardSide::inside;
      return none;
    }
    const bool turns = start.rate < 0.0 && end.rate > 0.0;
    if (turns) {
      const double trough = turning_point(k, a, b);
      const GuardSample lowest = at(k, trough);
      if (lowest.value < -lowest.rounding) {
        sides_[k] = GuardSide::inside;
        if (end.value > 0.0) return crossed(crossing(k, trough, b));
        return is_end && end.is_on() ? crossed(b) : none;
      }
    }
    if (sides_[k] == GuardSide::returning) {
      if (end.is_on() && end.rate < 0.0)
        sides_[k] = GuardSide::departing;
      else if (turns || end.rate >= 0.0 || is_end)
        return fail(IntegrationStatus::beyond_guard, b);
      return none;
    }
    // The state is still departing, which is valid if it moves in the right direction.
    return end.is_on() || end.rate < 0.0 ? none : fail(IntegrationStatus::ambiguous_start, a);
  }

  if (end.value > 0.0) return crossed(start.value > 0.0 ? a : crossing(k, a, b));
  if (start.rate > 0.0 && end.rate < 0.0) {
    const double peak = turning_point(k, a, b);
    const GuardSample highest = at(k, peak);
    if (highest.value > highest.rounding) return crossed(crossing(k, a, peak));
    if (highest.is_on()) return fail(IntegrationStatus::grazing, peak);
  }
  if (end.is_on() && end.is_tangent()) return fail(IntegrationStatus::grazing, b);
  if (is_end && end.is_on() && end.rate > 0.0) return crossed(b);
  return none;
}

}  // namespace saltus
