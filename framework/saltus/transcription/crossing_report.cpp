#include "saltus/transcription/crossing_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace saltus {
namespace {

// The guard must exceed this fraction of its largest value in the phase, or of its scale, to count
// as non-zero. After a jump it often starts at zero, to the solver's tolerance.
constexpr double side_share = 1e-6;

VectorXd argument(const Arguments& a, double t, const VectorXd& x, const VectorXd& u,
                  const VectorXd& p) {
  VectorXd z(a.size());
  z << t, x, u, p;
  return z;
}

// Finds the largest value of the guard beyond zero after it was before zero, with its time.
void find_early_crossing(const std::vector<std::pair<double, double>>& samples,
                         Solution::GuardCrossing& c) {
  for (const auto& [t, g] : samples) c.largest = std::max(c.largest, std::abs(g));
  const double side = side_share * c.largest;
  bool was_before = false;
  for (const auto& [t, g] : samples) {
    was_before = was_before || g < -side;
    if (!was_before || g <= std::max(side, c.early_amount)) continue;
    c.early_amount = g;
    c.early_time = t;
  }
}

// The active dynamics: those of the stored mode, or of the first mode inside all its guards
// (framework/design/events.md). Null on a guard, where a mode begins, ends or slides.
const Function* field_at(const PhaseDefinition& phase, const VectorXd& z) {
  const SwitchingSystem& s = phase.switching;
  if (s.modes.size() < 2) return &phase.dynamics;
  const int modes = static_cast<int>(s.modes.size());
  std::vector<char> is_left(modes, 0);
  for (const SwitchingSystem::Transition& t : s.transitions) {
    const double g = t.guard(z)[0];
    const VectorXd slopes = t.guard.dense_jacobian(z).row(0);
    if (std::abs(g) <= side_share * slopes.cwiseAbs().dot((z.array().abs() + 1.0).matrix()))
      return nullptr;
    if (crossing_sign(t.direction) * g > 0.0) is_left[t.from] = 1;
  }
  if (s.memory >= 0) {
    const auto mode = static_cast<int>(std::lround(z[phase.sizes.x(s.memory)]));
    return &s.modes[std::clamp(mode, 0, modes - 1)].dynamics;
  }
  const auto inside = std::ranges::find(is_left, 0);
  return inside == is_left.end() ? nullptr : &s.modes[inside - is_left.begin()].dynamics;
}

}  // namespace

std::vector<Solution::GuardCrossing> guard_crossings(const OptimalControlProblem& problem,
                                                     const Trajectory& trajectory, int samples) {
  std::vector<Solution::GuardCrossing> crossings;
  for (std::size_t j = 0; j < problem.phases().size(); ++j) {
    const PhaseDefinition& phase = problem.phases()[j];
    if (phase.end_guards.empty()) continue;
    const EndGuard& guard = phase.end_guards.front();
    const VectorXd& p = trajectory.phases()[j].parameters;
    const int nu = phase.sizes.nu;
    Solution::GuardCrossing c{
        .phase = phase.name, .event = guard.event, .declared = guard.crossing};
    std::vector<std::pair<double, double>> values;  // t and guard, oriented as rising
    const Trajectory::Piece* last = nullptr;
    for (const Trajectory::Piece& piece : trajectory.pieces()) {
      if (piece.phase != static_cast<int>(j)) continue;
      last = &piece;
      const VectorXd z =
          argument(phase.sizes, piece.start, piece.state, piece.coefficients.head(nu), p);
      values.emplace_back(piece.start, crossing_sign(guard.crossing) * guard.guard(z)[0]);
      for (int s = 1; s <= samples && piece.length > 0.0; ++s) {
        const double t = piece.start + piece.length * s / (samples + 1);
        if (&trajectory.piece_at(t) != &piece) continue;  // piece shorter than the time resolution
        const VectorXd inside =
            argument(phase.sizes, t, trajectory.state(t), trajectory.input(t), p);
        const double g = crossing_sign(guard.crossing) * guard.guard(inside)[0];
        if (std::isfinite(g)) values.emplace_back(t, g);
      }
    }
    if (last == nullptr) continue;
    find_early_crossing(values, c);
    c.time = last->end();
    const VectorXd z =
        argument(phase.sizes, c.time, last->end_state, last->coefficients.tail(nu), p);
    if (const Function* field = field_at(phase, z)) {
      const EndGuard::Rate rate = guard_rate(phase, *field, guard.guard, z);
      c.rate = rate.value;
      c.grazes = rate.grazes();
    } else {
      c.rate = std::numeric_limits<double>::quiet_NaN();
    }
    crossings.push_back(std::move(c));
  }
  return crossings;
}

std::string describe_crossing_error(const Solution::GuardCrossing& c) {
  if (c.is_as_declared()) return {};
  const std::string where =
      fmt::format("event '{}' that ends phase '{}' at t = {:.6g} s", c.event, c.phase, c.time);
  if (c.grazes)
    return fmt::format("{} grazes its guard (rate {:.3g} per second): its time is ill-defined",
                       where, c.rate);
  if (c.has_wrong_direction())
    return fmt::format(
        "{} has the wrong direction: the rate of the guard is {:.3g} per second, but the event is "
        "declared {}",
        where, c.rate, describe(c.declared));
  return fmt::format(
      "{} is not the first crossing: the guard crossed zero {} before, by {:.3g} at t = {:.6g} s",
      where, describe(c.declared), c.early_amount, c.early_time);
}

}  // namespace saltus
