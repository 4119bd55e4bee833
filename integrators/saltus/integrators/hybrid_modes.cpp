#include "saltus/integrators/hybrid_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/integrators/hybrid_sliding.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

// Rounding error of a sum of a few terms, each accurate to a few ulp after a step refined to the
// guard. Far below all integrator tolerances.
constexpr double on_guard = 1e-13;

// At distance eps from a tangency, the rate is of order sqrt(eps). Smaller rates are
// indistinguishable from a tangency in double precision.
constexpr double tangent = 1.5e-8;

IntervalProblem problem_of_mode(const IntervalProblem& problem, Function dynamics,
                                Function running_cost) {
  IntervalProblem mode = problem;
  mode.switching = {};
  mode.dynamics = std::move(dynamics);
  mode.running_cost = std::move(running_cost);
  return mode;
}

const Function& running_cost(const IntervalProblem& problem, int mode) {
  const Function& own = problem.switching.modes[mode].running_cost;
  return own ? own : problem.running_cost;
}

// Finds the states that affect the guard. The rates of other states do not matter for touching or
// crossing.
void find_relevant_states(const Arguments& sizes, const Function& dynamics, OutgoingGuard& guard) {
  const auto state = [&](int column) {
    const int i = column - sizes.x();
    return i >= 0 && i < sizes.nx ? i : -1;
  };
  std::vector<char> read(sizes.nx, 0);
  guard.function.jacobian_pattern().for_each([&](int, int column, int) {
    if (const int i = state(column); i >= 0) read[i] = 1;
  });
  guard.counts = read;
  dynamics.jacobian_pattern().for_each([&](int row, int column, int) {
    if (const int i = state(column); i >= 0 && read[row]) guard.counts[i] = 1;
  });
}

}  // namespace

HybridModes::HybridModes(const IntervalProblem& problem)
    : declared_(static_cast<int>(problem.switching.modes.size())) {
  const SwitchingSystem& system = problem.switching;
  system.check(problem.arguments, problem.nq());
  for (int m = 0; m < declared_; ++m) {
    FlowMode mode;
    mode.name = system.modes[m].name;
    mode.field = std::make_unique<IntervalField>(
        problem_of_mode(problem, system.modes[m].dynamics, running_cost(problem, m)));
    modes_.push_back(std::move(mode));
  }
  for (const SwitchingSystem::Transition& t : system.transitions) {
    OutgoingGuard guard;
    guard.name = t.name;
    guard.function = t.guard;
    guard.sign = crossing_sign(t.direction);
    guard.target = t.to;
    guard.reset = t.reset;
    find_relevant_states(problem.arguments, system.modes[t.from].dynamics, guard);
    modes_[t.from].guards.push_back(std::move(guard));
  }
  // Surfaces: the same guard without reset in both directions.
  for (int m = 0; m < declared_; ++m)
    for (OutgoingGuard& guard : modes_[m].guards) {
      if (guard.reset || guard.target == m) continue;
      const auto& back = modes_[guard.target].guards;
      for (std::size_t k = 0; k < back.size(); ++k)
        if (back[k].target == m && !back[k].reset && back[k].function.is(guard.function) &&
            back[k].sign == -guard.sign)
          guard.partner = static_cast<int>(k);
    }
  for (int m = 0; m < declared_; ++m)
    for (std::size_t k = 0; k < modes_[m].guards.size(); ++k)
      if (modes_[m].guards[k].partner >= 0 && modes_[m].guards[k].slide < 0)
        add_sliding(problem, m, static_cast<int>(k));
  if (system.memory >= 0 && count() > declared_)
    throw DefinitionError(
        fmt::format("the mode is stored in state {}, but sliding on the surface {} has no mode "
                    "number; use a separate guard for each direction.",
                    system.memory, modes_[declared_].name));
}

// Adds the mode that slides on guard k of mode m. "Below" is the side of m, whatever the sign of
// the guard.
void HybridModes::add_sliding(const IntervalProblem& problem, int m, int k) {
  const Arguments& sizes = problem.arguments;
  OutgoingGuard& there = modes_[m].guards[k];
  const int n = there.target, back = there.partner;
  const int slide = count();
  there.slide = slide;
  modes_[n].guards[back].slide = slide;
  const Function guard = there.function;
  const Function& f_m = problem.switching.modes[m].dynamics;
  const Function& f_n = problem.switching.modes[n].dynamics;
  const Function &cost_m = running_cost(problem, m), &cost_n = running_cost(problem, n);

  FlowMode mode;
  mode.name = "sliding on '" + there.name + "'";
  mode.surface = guard;
  mode.unsupported =
      problem.shape == InputShape::linear && depends_on_any(guard, sizes.u(), sizes.nu);
  Function cost = cost_m;
  if (cost && !cost_m.is(cost_n)) cost = sliding_mix(sizes, guard, f_m, f_n, cost_m, cost_n);
  const Function dynamics = sliding_mix(sizes, guard, f_m, f_n, f_m, f_n);
  mode.field = std::make_unique<IntervalField>(problem_of_mode(problem, dynamics, std::move(cost)));
  const auto leave = [&](int target, int partner, const Function& f, double sign) {
    OutgoingGuard out;
    out.name = there.name;
    out.function = surface_rate(sizes, guard, f, sign);
    out.target = target;
    out.partner = partner;
    out.ends_sliding = true;
    mode.guards.push_back(std::move(out));
  };
  leave(m, k, f_m, -there.sign);  // sign r_m > 0 while sliding
  leave(n, back, f_n, there.sign);
  for (const int side : {m, n})  // other events of both sides also apply on the surface
    for (const OutgoingGuard& other : modes_[side].guards) {
      if (other.function.is(guard)) continue;
      mode.guards.push_back(other);
      mode.guards.back().partner = -1;
      mode.guards.back().slide = -1;
    }
  for (OutgoingGuard& outgoing : mode.guards) find_relevant_states(sizes, dynamics, outgoing);
  modes_.push_back(std::move(mode));
}

int HybridModes::largest_guard_count() const {
  std::size_t most = 0;
  for (const FlowMode& mode : modes_) most = std::max(most, mode.guards.size());
  return static_cast<int>(most);
}

int HybridModes::largest_entry_count() const {
  int most = 0;
  const auto consider = [&](const Function& f) {
    if (f) most = std::max(most, f.jacobian_pattern().entries());
  };
  for (const FlowMode& mode : modes_) {
    most = std::max(most, mode.field->entries());
    consider(mode.surface);
    for (const OutgoingGuard& guard : mode.guards) {
      consider(guard.function);
      consider(guard.reset);
    }
  }
  return most;
}

void HybridModes::load(const double* w) {
  for (FlowMode& mode : modes_) mode.field->load(w);
}

bool GuardSample::is_on() const { return std::abs(value) <= rounding; }
bool GuardSample::is_tangent() const { return std::abs(rate) <= tangent * scale; }

GuardEvaluator::GuardEvaluator(const IntervalProblem& problem, const HybridModes& modes)
    : sizes_(problem.arguments),
      nominal_(problem.nominal_state.size() > 0 ? problem.nominal_state
                                                : VectorXd::Ones(problem.arguments.nx)),
      reach_(VectorXd::Zero(sizes_.nx)),
      z_(sizes_.size()),
      rates_(sizes_.nx + problem.nq()),
      slope_(1) {
  entries_.resize(modes.largest_entry_count());
}

void GuardEvaluator::sample(const FlowMode& mode, double s, const double* x, GuardSample* samples) {
  mode.field->argument(s, x, z_.data());
  mode.field->value(z_.data(), rates_.data());
  for (std::size_t k = 0; k < mode.guards.size(); ++k) samples[k] = evaluate(mode, mode.guards[k]);
}

GuardSample GuardEvaluator::sample(const FlowMode& mode, int guard, double s, const double* x) {
  mode.field->argument(s, x, z_.data());
  mode.field->value(z_.data(), rates_.data());
  return evaluate(mode, mode.guards[guard]);
}

void GuardEvaluator::begin(const double* x) {
  reach_.setZero();
  pass(x);
}

void GuardEvaluator::pass(const double* x) {
  for (int i = 0; i < sizes_.nx; ++i)
    if (std::isfinite(x[i])) reach_[i] = std::max(reach_[i], std::abs(x[i]));
}

GuardSample GuardEvaluator::evaluate(const FlowMode& mode, const OutgoingGuard& guard) {
  GuardSample sample;
  const SparsityPattern& pattern = guard.function.jacobian_pattern();
  guard.function.jacobian(z_.data(), &sample.value, entries_.data());
  mode.field->explicit_slope(pattern, entries_.data(), slope_.data());
  const double h = mode.field->length();
  double gradient = 0.0, speed = 0.0;
  sample.rate = slope_[0];
  for (int e = 0; e < pattern.entries(); ++e) {
    const int col = pattern.col(e), i = col - sizes_.x();
    const bool state = i >= 0 && i < sizes_.nx;
    const double size =
        state ? std::max(std::abs(z_[col]), reach_[i]) + nominal_[i] : std::abs(z_[col]);
    sample.rounding += on_guard * std::abs(entries_[e]) * size;
    if (!state) continue;
    sample.rate += entries_[e] * h * rates_[i];
    gradient += entries_[e] * nominal_[i] * entries_[e] * nominal_[i];
  }
  for (int i = 0; i < sizes_.nx; ++i) {
    if (!guard.counts[i]) continue;
    const double r = h * rates_[i] / nominal_[i];
    speed += r * r;
  }
  sample.scale = std::sqrt(gradient * speed) + std::abs(slope_[0]);
  sample.value *= guard.sign;
  sample.rate *= guard.sign;
  return sample;
}

}  // namespace saltus
