#include "saltus/verify/mode_switches.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

// A guard counts as zero within this fraction of its terms, because nodes have the accuracy of a
// solver.
constexpr double on_guard = 1e-8;
constexpr int parts = 4;  // parts of a step at which guards are evaluated

}  // namespace

// The guard, negative before the event.
double ModeSwitches::guard(const SwitchingSystem::Transition& t, PlanField& field, double s,
                           const double* x) {
  double g = 0.0;
  t.guard.value(field.argument(s, x), &g);
  return crossing_sign(t.direction) * g;
}

double ModeSwitches::guard_rate(const SwitchingSystem::Transition& t, PlanField& field, double s,
                                const double* x, double& size) {
  const Arguments& a = field.sizes();
  std::vector<double> rates(field.outputs()), y(x, x + a.nx),
      entries(t.guard.jacobian_pattern().entries());
  y.resize(field.outputs());
  field.rates(s, y.data(), rates.data());
  double g = 0.0, rate = 0.0;
  size = 0.0;
  const double* z = field.argument(s, x);
  t.guard.jacobian(z, &g, entries.data());
  t.guard.jacobian_pattern().for_each([&](int, int column, int e) {
    const double slope = entries[e];
    if (column == a.t()) rate += slope * field.length();
    if (column >= a.x() && column < a.x(a.nx)) rate += slope * rates[column - a.x()];
    if (column >= a.u() && column < a.u(a.nu)) rate += slope * field.input_change(column - a.u());
    size += std::abs(slope) * (std::abs(z[column]) + 1.0);
  });
  return crossing_sign(t.direction) * rate;
}

bool ModeSwitches::start(PlanField& field, const VectorXd& state) {
  x_.assign(state.data(), state.data() + state.size());
  transition_ = -1;
  const int modes = static_cast<int>(system().modes.size());
  if (modes == 0) return true;
  if (system().memory >= 0) {
    mode_ = std::clamp(static_cast<int>(std::lround(state[system().memory])), 0, modes - 1);
    field.use(system().modes[mode_].dynamics);
    return true;
  }
  for (int m = 0; m < modes; ++m) {
    field.use(system().modes[m].dynamics);
    bool fits = true;
    for (const SwitchingSystem::Transition& t : system().transitions) {
      if (t.from != m) continue;
      double size = 0.0;
      const double rate = guard_rate(t, field, 0.0, x_.data(), size);
      const double g = guard(t, field, 0.0, x_.data());
      fits = fits && (g < -on_guard * size || (g <= on_guard * size && rate < 0.0));
    }
    if (!fits) continue;
    mode_ = m;
    return true;
  }
  return false;
}

std::optional<double> ModeSwitches::first_event(PlanField& field, const ControlledSteps& steps) {
  x_.resize(field.outputs());
  transition_ = -1;
  double first = 2.0;
  const auto value = [&](const SwitchingSystem::Transition& t, double theta) {
    steps.state_at(theta, x_.data());
    return guard(t, field, steps.step_start() + theta * steps.step_length(), x_.data());
  };
  for (std::size_t i = 0; i < system().transitions.size(); ++i) {
    const SwitchingSystem::Transition& t = system().transitions[i];
    if (t.from != mode_) continue;
    double before = value(t, 0.0), from = 0.0;
    for (int part = 1; part <= parts; ++part) {
      const double to = static_cast<double>(part) / parts, here = value(t, to);
      if (before < 0.0 && here >= 0.0) {
        double low = from, high = to;
        for (int k = 0; k < 60 && high - low > 1e-15; ++k) {
          const double middle = 0.5 * (low + high);
          (value(t, middle) < 0.0 ? low : high) = middle;
        }
        if (high < first) {
          first = high;
          transition_ = static_cast<int>(i);
        }
        break;
      }
      before = here;
      from = to;
    }
  }
  if (transition_ < 0) return std::nullopt;
  return first;
}

bool ModeSwitches::take(PlanField& field, double s, std::vector<double>& y) {
  const SwitchingSystem::Transition& t = system().transitions[transition_];
  if (t.reset) {
    std::vector<double> after(field.states());
    t.reset.value(field.argument(s, y.data()), after.data());
    std::ranges::copy(after, y.begin());
  }
  mode_ = t.to;
  if (system().memory >= 0) y[system().memory] = mode_;
  field.use(system().modes[mode_].dynamics);
  // The new field must lead away from every guard that is zero at the state.
  for (const SwitchingSystem::Transition& next : system().transitions) {
    if (next.from != mode_) continue;
    double size = 0.0;
    const double rate = guard_rate(next, field, s, y.data(), size);
    if (guard(next, field, s, y.data()) >= -1e-9 * size && rate >= 0.0) return false;
  }
  return true;
}

}  // namespace saltus
