#include "saltus/ocp/phase_definition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

// Reproducible points z of the phase around its guesses, both near and far. Locally flat guards are
// thus not taken for constant ones.
class SeededPoints {
 public:
  SeededPoints(const PhaseDefinition& phase, const Bounds& start) : phase_(phase), start_(start) {}

  VectorXd next() {
    constexpr double spreads[] = {1.0, 10.0, 100.0};  // in nominal magnitudes
    const double spread = spreads[count_++ % 3];
    const Arguments& a = phase_.sizes;
    VectorXd z(a.size());
    const double fraction = 0.5 * (1.0 + symmetric());
    const double longest =
        std::isfinite(phase_.duration.upper) ? phase_.duration.upper : phase_.duration_guess;
    z[a.t()] = begin(spread * longest) + fraction * longest;
    const auto values = [&](const Guess& guess, int size) -> VectorXd {
      return guess.is_given() ? guess.at(fraction) : VectorXd::Zero(size);
    };
    const VectorXd x = values(phase_.state_guess, a.nx), u = values(phase_.input_guess, a.nu);
    for (int i = 0; i < a.nx; ++i)
      z[a.x(i)] = within(x[i] + spread * phase_.nominal_state[i] * symmetric(),
                         whole(phase_.state_bounds, i));
    for (int i = 0; i < a.nu; ++i)
      z[a.u(i)] = within(u[i] + spread * phase_.nominal_input[i] * symmetric(),
                         whole(phase_.input_bounds, i));
    int p = 0;
    for (const PhaseDefinition::ParameterBlock& block : phase_.parameters)
      for (int i = 0; i < block.value.size(); ++i, ++p)
        // Data change between solves and have no bounds.
        z[a.p(p)] = within(block.value[i] + block.nominal[i] * symmetric(),
                           block.unknown ? block.bounds[i] : unbounded());
    return z;
  }

 private:
  // Uniform in [-1, 1]. Distributions of the standard library differ between libraries.
  double symmetric() { return 2.0 * (random_() / 4294967295.0) - 1.0; }
  // Start time of the phase. `room` is the assumed distance of an open end from the other end.
  double begin(double room) {
    double first = start_.lower, last = start_.upper;
    if (first == -infinity) first = std::min(last, 0.0) - room;
    if (last == infinity) last = std::max(first, 0.0) + room;
    return first + 0.5 * (1.0 + symmetric()) * (last - first);
  }
  static Bounds whole(const std::vector<PhaseDefinition::ComponentBounds>& list, int component) {
    Bounds all;
    for (const PhaseDefinition::ComponentBounds& b : list)
      if (b.component == component && b.window.is_whole()) {
        all.lower = std::max(all.lower, b.bounds.lower);
        all.upper = std::min(all.upper, b.bounds.upper);
      }
    return all;
  }
  static double within(double value, const Bounds& b) {
    return std::max(b.lower, std::min(b.upper, value));
  }

  const PhaseDefinition& phase_;
  Bounds start_;
  std::mt19937 random_{20};
  int count_ = 0;
};

}  // namespace

bool EndGuard::Rate::grazes() const { return !(std::abs(value) > grazing_fraction * scale); }

EndGuard::Rate guard_rate(const PhaseDefinition& phase, const Function& dynamics,
                          const Function& guard, const VectorRef& z) {
  const Arguments& a = phase.sizes;
  const VectorXd f = dynamics(z);
  const MatrixXd slopes = guard.dense_jacobian(z);
  const Eigen::RowVectorXd g_x = slopes.row(0).segment(a.x(), a.nx);
  EndGuard::Rate rate;
  rate.value = slopes(0, a.t()) + g_x * f;
  rate.scale =
      std::abs(slopes(0, a.t())) + g_x.transpose().cwiseProduct(phase.nominal_state).norm() *
                                       f.cwiseQuotient(phase.nominal_state).norm();
  return rate;
}

void check_end_guard(const PhaseDefinition& phase, const EndGuard& guard, const Bounds& start) {
  const auto fail = [&](const std::string& what) {
    throw DefinitionError(fmt::format("phase '{}', event '{}': {}", phase.name, guard.event, what));
  };
  if (guard.guard.outputs() != 1)
    fail(fmt::format("a guard must be a scalar, but it has {} rows", guard.guard.outputs()));
  if (!phase.has_free_duration())
    fail(
        fmt::format("the duration is fixed at {} s, so the event cannot end the phase; give the "
                    "duration an interval, or use reach() for the condition",
                    phase.duration.lower));
  constexpr int tried = 48;
  constexpr double rounding = 1e-12;  // rounding error of sums of a few products
  std::vector<Function> fields;       // any of them may be active at the end of the phase
  fields.reserve(phase.switching.modes.size() + 1);
  for (const SwitchingSystem::Mode& mode : phase.switching.modes) fields.push_back(mode.dynamics);
  if (fields.empty()) fields.push_back(phase.dynamics);
  SeededPoints points(phase, start);
  int finite = 0, moving = 0;
  double lowest = infinity, highest = -infinity;
  for (int i = 0; i < tried; ++i) {
    const VectorXd z = points.next();
    for (const Function& field : fields) {
      const EndGuard::Rate rate = guard_rate(phase, field, guard.guard, z);
      if (!std::isfinite(rate.value) || !std::isfinite(rate.scale)) continue;  // outside its domain
      ++finite;
      if (std::abs(rate.value) > rounding * rate.scale) ++moving;
      lowest = std::min(lowest, rate.value);
      highest = std::max(highest, rate.value);
    }
  }
  if (finite == 0) return;  // the solution reports the rate instead
  if (moving == 0)
    fail("the guard never crosses zero: its rate g_t + g_x f is zero at all tested points");
  const double size = std::max(std::abs(lowest), std::abs(highest));
  if (highest - lowest <= rounding * size && crossing_sign(guard.crossing) * lowest < 0.0)
    fail(fmt::format("the guard always changes by {:.6g} per second, so it never crosses zero {}",
                     lowest, describe(guard.crossing)));
}

}  // namespace saltus
