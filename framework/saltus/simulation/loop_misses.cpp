#include "saltus/simulation/loop_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/verify/plan_rows.hpp"

namespace saltus {
namespace {

// A shorter remainder is solved with this length in seconds, so that phases may end late by as
// much.
constexpr double late = 20.0 * same_instant;

}  // namespace

bool is_in_force(const Window& window, const Schedule& schedule, double phase_start, double t) {
  const auto time_of = [&](const Instant& instant) {
    if (instant.is_event()) return schedule.time_of(instant.event());
    return instant.seconds() + (window.clock == Clock::phase ? phase_start : 0.0);
  };
  if (window.from && t < time_of(*window.from) - same_instant) return false;
  if (window.to && t >= time_of(*window.to) - same_instant) return false;
  return window.modes.empty() ||
         std::ranges::find(window.modes, schedule.mode_at(t + same_instant)) != window.modes.end();
}

double MissRecord::Tolerance::of(const std::string& term, const Bounds& bounds,
                                 double nominal) const {
  if (const auto it = of_term.find(term); it != of_term.end()) return it->second;
  double size = std::max(1.0, std::abs(nominal));
  for (const double side : {bounds.lower, bounds.upper})
    if (std::isfinite(side)) size = std::max(size, std::abs(side));
  return relative * size;
}

std::string describe(const LoopMiss& miss) {
  return fmt::format("phase '{}', '{}' is missed by {:.3g} at t = {:.6g} s (tolerance {:.2g})",
                     miss.phase, miss.term, miss.amount, miss.time, miss.tolerance);
}

MissRecord::MissRecord(const OptimalControlProblem& problem, MissRecord::Tolerance tolerance,
                       std::function<VectorXd(int)> parameters, bool recedes)
    : problem_(problem),
      tolerance_(std::move(tolerance)),
      parameters_(std::move(parameters)),
      recedes_(recedes) {
  if (!(tolerance_.relative >= 0.0))
    throw DefinitionError(
        fmt::format("closed loop: the relative tolerance of misses is {}, expected "
                    "at least 0",
                    tolerance_.relative));
  std::set<std::string> names{"duration", "total time"};
  for (const PhaseDefinition& phase : problem_.phases()) {
    for (const Term& term : phase.terms) names.insert(term.name);
    for (int i = 0; i < phase.sizes.nx; ++i) names.insert(fmt::format("state {}", i));
    for (int i = 0; i < phase.sizes.nu; ++i) names.insert(fmt::format("input {}", i));
  }
  for (const auto& [term, allowed] : tolerance_.of_term) {
    if (!names.contains(term))
      throw DefinitionError(
          fmt::format("closed loop: a tolerance names the term '{}', which no phase has", term));
    if (!(allowed >= 0.0))
      throw DefinitionError(fmt::format(
          "closed loop: the tolerance of '{}' is {}, expected at least 0", term, allowed));
  }
}

VectorXd MissRecord::argument(double t, const VectorXd& state, const VectorXd& input) const {
  const Arguments& sizes = definition().sizes;
  VectorXd z = VectorXd::Zero(sizes.size());
  z[0] = t;
  z.segment(1, std::min<Eigen::Index>(sizes.nx, state.size())) =
      state.head(std::min<Eigen::Index>(sizes.nx, state.size()));
  z.segment(1 + sizes.nx, std::min<Eigen::Index>(sizes.nu, input.size())) =
      input.head(std::min<Eigen::Index>(sizes.nu, input.size()));
  z.tail(sizes.np) = parameters_(phase_);
  return z;
}

bool MissRecord::is_in_force(const Window& window, double t) const {
  return saltus::is_in_force(window, problem_.schedule(), recedes_ ? t : entered_, t);
}

void MissRecord::judge(const std::string& term, double t, double value, const Bounds& bounds,
                       double nominal, bool at_end) {
  // The other bound, which may be a huge placeholder, has no influence.
  const Bounds violated = value < bounds.lower ? at_least(bounds.lower) : at_most(bounds.upper);
  const LoopMiss miss{definition().name,
                      term,
                      t,
                      beyond(value, bounds),
                      tolerance_.of(term, violated, nominal),
                      at_end};
  if (!(miss.amount > miss.tolerance)) return;
  for (LoopMiss& known : largest_)
    if (known.phase == miss.phase && known.term == miss.term && known.at_end == at_end) {
      if (miss.amount * known.tolerance > known.amount * miss.tolerance) known = miss;
      return;
    }
  largest_.push_back(miss);
}

void MissRecord::judge(const Term& term, double t, const VectorXd& z, bool at_end) {
  VectorXd value = VectorXd::Constant(term.function.outputs(), std::nan(""));
  try {
    value = term.function(z);
  } catch (...) {  // a user formula has no value there
  }
  for (int i = 0; i < value.size(); ++i) judge(term.name, t, value[i], term.bounds[i], 1.0, at_end);
}

void MissRecord::judge_once(Term::Domain domain, double t, const VectorXd& state,
                            const VectorXd& input) {
  const VectorXd z = argument(t, state, input);
  for (const Term& term : definition().terms)
    if (term.domain == domain && term.kind == Term::Kind::constraint && !term.soft)
      judge(term, t, z, true);
}

void MissRecord::begin(double t, const VectorXd& state, const VectorXd& input) {
  begin_ = entered_ = t;
  if (!recedes_) judge_once(Term::Domain::phase_start, t, state, input);
}

void MissRecord::look(double t, const VectorXd& state, const VectorXd& input) {
  if (is_over_) return;
  const PhaseDefinition& phase = definition();
  const VectorXd z = argument(t, state, input);
  for (const Term& term : phase.terms)
    if (term.kind == Term::Kind::constraint && term.domain == Term::Domain::running && !term.soft &&
        is_in_force(term.window, t))
      judge(term, t, z, false);
  const auto bounds = [&](const std::vector<PhaseDefinition::ComponentBounds>& all,
                          const char* what, const VectorXd& values, const VectorXd& nominal) {
    for (const PhaseDefinition::ComponentBounds& b : all)
      if (b.component < values.size() && is_in_force(b.window, t))
        judge(fmt::format("{} {}", what, b.component), t, values[b.component], b.bounds,
              b.component < nominal.size() ? nominal[b.component] : 1.0, false);
  };
  bounds(phase.state_bounds, "state", state, phase.nominal_state);
  bounds(phase.input_bounds, "input", input, phase.nominal_input);
}

void MissRecord::end_phase(const HybridEvent& event, const VectorXd& input) {
  if (is_over_ || recedes_) return;
  judge_once(Term::Domain::phase_end, event.time, event.before, input);
  const auto judge_time = [&](const char* what, double value, const Bounds& bounds) {
    judge(what, event.time, value, {bounds.lower - late, bounds.upper + late}, 1.0, true);
  };
  judge_time("duration", event.time - entered_, definition().duration);
  if (phase_ + 1 == static_cast<int>(problem_.phases().size())) {
    judge_time("total time", event.time - begin_, problem_.total_time());
    is_over_ = true;
    return;
  }
  ++phase_;
  entered_ = event.time;
  judge_once(Term::Domain::phase_start, event.time, event.after, input);
}

std::vector<LoopMiss> MissRecord::misses() const {
  std::vector<LoopMiss> result = largest_;
  const auto weight = [](const LoopMiss& m) {
    return m.tolerance > 0.0 ? m.amount / m.tolerance : infinity;
  };
  std::stable_sort(result.begin(), result.end(),
                   [&](const LoopMiss& a, const LoopMiss& b) { return weight(a) > weight(b); });
  return result;
}

}  // namespace saltus
