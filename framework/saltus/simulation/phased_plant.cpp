#include "saltus/simulation/plants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/ocp/cost_functions.hpp"
#include "saltus/ocp/interval_problem_of.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/verify/plan_rows.hpp"

namespace saltus {
namespace {

// Fraction of a piece: earlier events count as events at the start of the piece.
constexpr double at_once = 1e-16;

bool is_running_cost(const Term& term) {
  return term.kind != Term::Kind::constraint && term.domain == Term::Domain::running;
}

VectorXd given_parameters(const PhaseDefinition& phase) {
  VectorXd p(phase.sizes.np);
  Eigen::Index at = 0;
  for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
    p.segment(at, block.value.size()) = block.value;
    at += block.value.size();
  }
  return p;
}

// Keeps the largest miss of each term of each phase.
void note(std::vector<PhasedPlant::Miss>& misses, PhasedPlant::Miss miss) {
  if (miss.amount <= 0.0) return;
  for (PhasedPlant::Miss& known : misses)
    if (known.phase == miss.phase && known.term == miss.term) {
      if (miss.amount > known.amount) known = std::move(miss);
      return;
    }
  misses.push_back(std::move(miss));
}

}  // namespace

PhasedPlant::PhasedPlant(OptimalControlProblem problem, const IntegratorChoice& scheme)
    : problem_(std::move(problem)),
      clock_(problem_.start_time()),
      entered_(time()),
      state_(problem_.start_guess()) {
  if (!scheme) throw DefinitionError("plant: no integrator is given");
  problem_.check();
  name_ = scheme->name();
  for (const PhaseDefinition& phase : problem_.phases()) {
    if (!phase.switching.empty())
      throw DefinitionError(fmt::format("plant: phase '{}' has inner events", phase.name));
    IntervalProblem interval = interval_problem_of(phase);
    Phase& p = phases_.emplace_back();
    std::vector<Function> running;
    for (std::size_t t = 0; t < phase.terms.size(); ++t)
      if (is_running_cost(phase.terms[t])) {
        p.running.push_back(static_cast<int>(t));
        running.push_back(cost_function(phase.terms[t]));
      }
    if (!running.empty()) {
      p.costs = SelectiveStack(std::move(running));
      interval.running_cost = p.costs.function();
    }
    p.integrator = scheme->make(interval);
    p.parameters = given_parameters(phase);
  }
  ends_.assign(phases_.size(), infinity);
}

std::size_t PhasedPlant::checked(int phase) const {
  if (phase < 0 || phase >= phases())
    throw DefinitionError(
        fmt::format("plant: there is no phase {}; it has {} phases", phase, phases()));
  return static_cast<std::size_t>(phase);
}

void PhasedPlant::end_phase_at(int phase, double t) {
  if (std::isnan(t)) throw DefinitionError("plant: the end of a phase is NaN");
  ends_[checked(phase)] = t;
}

double PhasedPlant::over_since() const {
  if (!is_over()) throw DefinitionError("plant: its last phase has not ended");
  return *over_since_;
}

VectorXd PhasedPlant::argument(const VectorRef& input) const {
  VectorXd z(definition().sizes.size());
  z << time(), state_, input, phases_[phase_].parameters;
  return z;
}

// A phase that starts within a tick may have other inputs than the plan of that tick.
VectorXd PhasedPlant::fitted(const VectorRef& input) const {
  VectorXd u = VectorXd::Zero(inputs());
  const Eigen::Index n = std::min(u.size(), input.size());
  u.head(n) = input.head(n);
  return u;
}

bool PhasedPlant::advance(const VectorRef& input, double length) {
  checked(phase_);
  const auto fits = [&](const PhaseDefinition& p) { return p.sizes.nu == input.size(); };
  if (std::ranges::none_of(problem_.phases(), fits))
    throw DefinitionError(
        fmt::format("plant: the input has {} entries, expected {}", input.size(), inputs()));
  if (!(length >= 0.0)) {
    failure_ = describe_bad_length(length);
    return false;
  }
  const auto moment = [this] {
    return std::tie(phase_, clock_, entered_, state_, over_since_, cost_, has_begun_, passed_guard_,
                    at_ends_, on_the_way_, events_);
  };
  auto before = std::apply([](const auto&... part) { return std::make_tuple(part...); }, moment());
  try {
    if (advance_from_here(input, length)) return true;
  } catch (...) {
    moment() = std::move(before);
    throw;
  }
  moment() = std::move(before);
  return false;
}

bool PhasedPlant::advance_from_here(const VectorRef& input, double length) {
  double left = length;
  if (!has_begun_) begin_phase(fitted(input));
  while (!is_over() && left > 0.0) {
    if (std::exchange(passed_guard_, false)) {
      end_phase(fitted(input));
      continue;
    }
    const double planned = definition().end_guards.empty() ? ends_[phase_] - time() : infinity;
    const int phase = phase_;
    const std::optional<double> gone = move(fitted(input), std::clamp(planned, 0.0, left));
    if (!gone) return false;
    if (phase_ == phase && planned <= left + same_instant) end_phase(fitted(input));
    left -= *gone;
  }
  if (is_over()) clock_.move_on(left);
  return true;
}

double PhasedPlant::end() const {
  return phase_ + 1 == phases() && definition().end_guards.empty() ? ends_[phase_] : infinity;
}

double PhasedPlant::guard(const VectorRef& input) const {
  const EndGuard& g = definition().end_guards.front();
  return crossing_sign(g.crossing) * g.guard(argument(input))[0];
}

double PhasedPlant::growth(const VectorRef& input) const {
  const EndGuard& g = definition().end_guards.front();
  return crossing_sign(g.crossing) *
         guard_rate(definition(), definition().dynamics, g.guard, argument(input)).value;
}

// On the guard or beyond it, the direction of motion decides. The motion leaves the phase, or it
// returns first, like a bouncing ball that rounding put below the ground.
bool PhasedPlant::is_leaving(const VectorRef& input) const {
  const double g = guard(input), rate = growth(input);
  return (g > 0.0 && rate >= 0.0) || (g == 0.0 && rate > 0.0);
}

IntegrationStatus PhasedPlant::integrate(const VectorRef& input, double length) {
  const Phase& p = phases_[phase_];
  VectorXd w(p.integrator->arguments().size());
  w << state_, input, p.parameters, time(), length;
  end_.resize(p.integrator->outputs());
  return p.integrator->value(w.data(), end_.data());
}

// Moves to the end of the piece, or to the zero of the guard where the next phase starts. Returns
// the length in seconds; empty if the integration fails.
std::optional<double> PhasedPlant::move(const VectorRef& input, double length) {
  if (length <= 0.0) return 0.0;
  const VectorXd start = state_;
  const PlantClock begin = clock_;
  double gone = 0.0;
  const auto go = [&](double by) {
    state_ = start;
    clock_ = begin;
    const IntegrationStatus status = integrate(input, by);
    if (status != IntegrationStatus::success) {
      failure_ = phases_[phase_].integrator->failure();
      if (failure_.empty()) failure_ = describe(status);
      return false;
    }
    state_ = end_.head(start.size());
    clock_.move_on(by);
    gone = by;
    return true;
  };
  const bool has_guard = !definition().end_guards.empty();
  bool inside = has_guard && guard(input) < 0.0;
  const Phase& p = phases_[phase_];
  std::vector<bool> counts;  // costs whose windows contain the start of the piece
  for (std::size_t i = 0; i < p.running.size(); ++i) {
    counts.push_back(is_in_force(definition().terms[p.running[i]].window, begin.time()));
    if (p.integrator->follows_running_costs()) p.costs.evaluate(static_cast<int>(i), counts[i]);
  }
  if (!go(length)) return {};
  if (has_guard && !std::isfinite(guard(input))) {
    failure_ = fmt::format("the guard of phase '{}' is not finite at t = {:.6g} s",
                           definition().name, time());
    return {};
  }
  const bool crossed = has_guard && (inside ? guard(input) >= 0.0 : is_leaving(input));
  if (crossed) {
    double low = 0.0, high = length;
    // Bisection ends at adjacent numbers or at once: the event is as accurate as the integrator.
    const auto go_where_begins = [&](const auto& holds) {
      for (double middle = 0.5 * (low + high);
           middle > low && middle < high && high > at_once * length; middle = 0.5 * (low + high)) {
        if (!go(middle)) return false;
        (holds() ? high : low) = middle;
      }
      return go(high);
    };
    if (!inside) {  // the guard may have returned before it crossed zero
      if (!go_where_begins([&] { return growth(input) >= 0.0; })) return {};
      inside = guard(input) < 0.0;
      low = std::exchange(high, length);
    }
    if (inside && !go_where_begins([&] { return guard(input) >= 0.0; })) return {};
  }
  for (std::size_t i = 0; i < p.running.size(); ++i)
    if (counts[i]) cost_ += end_[start.size() + static_cast<Eigen::Index>(i)];
  check_path_constraints(input);
  if (crossed) end_phase(input);
  return gone;
}

// A window limit inside a piece takes effect with the next piece.
bool PhasedPlant::is_in_force(const Window& window, double t) const {
  return saltus::is_in_force(window, problem_.schedule(), entered_, t);
}

void PhasedPlant::count_once(Term::Domain domain, const VectorRef& input) {
  const VectorXd z = argument(input);
  for (const Term& term : definition().terms) {
    if (term.domain != domain) continue;
    if (term.kind != Term::Kind::constraint) {
      cost_ += cost_function(term)(z)[0];
    } else if (!term.soft) {
      const VectorXd value = term.function(z);
      for (int i = 0; i < value.size(); ++i)
        note(at_ends_, {definition().name, term.name, time(), beyond(value[i], term.bounds[i])});
    }
  }
}

void PhasedPlant::check_path_constraints(const VectorRef& input) {
  const VectorXd z = argument(input);
  const PhaseDefinition& phase = definition();
  for (const Term& term : phase.terms) {
    if (term.kind != Term::Kind::constraint || term.domain != Term::Domain::running || term.soft ||
        !is_in_force(term.window, time()))
      continue;
    const VectorXd value = term.function(z);
    for (int i = 0; i < value.size(); ++i)
      note(on_the_way_, {phase.name, term.name, time(), beyond(value[i], term.bounds[i])});
  }
  for (const PhaseDefinition::ComponentBounds& b : phase.state_bounds)
    if (is_in_force(b.window, time()))
      note(on_the_way_, {phase.name, fmt::format("bounds of state {}", b.component), time(),
                         beyond(state_[b.component], b.bounds)});
}

void PhasedPlant::begin_phase(const VectorRef& input) {
  has_begun_ = true;
  entered_ = time();
  count_once(Term::Domain::phase_start, input);
  if (definition().end_guards.empty()) return;
  passed_guard_ = passed_guard_ || is_leaving(input);
}

void PhasedPlant::end_phase(const VectorRef& input) {
  count_once(Term::Domain::phase_end, input);
  const PhaseDefinition& ended = definition();
  HybridEvent event;
  event.time = time();
  event.before = event.after = state_;
  event.mode_before = event.mode_after = ended.name;
  event.name = ended.end_guards.empty() ? "switch" : ended.end_guards.front().event;
  if (phase_ + 1 == phases()) {
    over_since_ = time();
    event.name = "end";
  } else {
    const Jump& jump = problem_.jumps()[phase_ + 1];
    event.after = jump.apply(time(), state_, phases_[phase_].parameters);
    if (jump.map) {
      event.kind = HybridEvent::Kind::jumps;
      if (ended.end_guards.empty()) event.name = jump.name;
    }
    state_ = event.after;
    ++phase_;
    event.mode_after = definition().name;
  }
  events_.push_back(std::move(event));
  if (!is_over()) begin_phase(fitted(input));
}

void PhasedPlant::disturb(const VectorRef& change) {
  if (change.size() != state_.size())
    throw DefinitionError(
        fmt::format("plant: the disturbance of the state has {} entries, expected {}",
                    change.size(), state_.size()));
  if (is_over()) return;
  const VectorXd u = VectorXd::Zero(inputs());
  const bool has_guard = !definition().end_guards.empty();
  const bool was_before = has_guard && guard(u) <= 0.0;
  state_ += change;
  // On the guard, the direction of motion decides at the start of the next piece.
  passed_guard_ = (passed_guard_ || was_before) && guard(u) > 0.0;
}

}  // namespace saltus
