#include "saltus/ocp/problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"

namespace saltus {

OptimalControlProblem& OptimalControlProblem::start_at(VectorXd state) {
  start_bounds_.clear();
  for (const double v : state) start_bounds_.push_back(exactly(v));
  start_guess_ = std::move(state);
  return *this;
}

OptimalControlProblem& OptimalControlProblem::start_at(std::initializer_list<double> state) {
  VectorXd x(state.size());
  int i = 0;
  for (const double v : state) x[i++] = v;
  return start_at(std::move(x));
}

OptimalControlProblem& OptimalControlProblem::start_within(std::vector<Bounds> bounds,
                                                           VectorXd guess) {
  start_bounds_ = std::move(bounds);
  for (Bounds& b : start_bounds_) b = without_sentinels(b);
  start_guess_ = std::move(guess);
  return *this;
}

OptimalControlProblem& OptimalControlProblem::start_time(double t) {
  start_time_ = t;
  start_time_bounds_.reset();
  return *this;
}

OptimalControlProblem& OptimalControlProblem::start_time(Bounds bounds, double guess) {
  start_time_ = guess;
  start_time_bounds_ = without_sentinels(bounds);
  return *this;
}

OptimalControlProblem& OptimalControlProblem::schedule(Schedule schedule) {
  schedule_ = std::move(schedule);
  return *this;
}

OptimalControlProblem& OptimalControlProblem::costs(CostRule rule) {
  cost_rule_ = rule;
  return *this;
}

const PhaseDefinition& OptimalControlProblem::phase_at(int j) const {
  if (j < 0 || j >= static_cast<int>(phases_.size()))
    throw DefinitionError(fmt::format("problem '{}' has {} phases, so there is no phase {}", name_,
                                      phases_.size(), j));
  return phases_[j];
}

PhaseDefinition& OptimalControlProblem::editable_phase(int j) {
  return const_cast<PhaseDefinition&>(phase_at(j));
}

Link& OptimalControlProblem::editable_link(int i) {
  if (i < 0 || i >= static_cast<int>(links_.size()))
    throw DefinitionError(
        fmt::format("problem '{}' has {} links, so there is no link {}", name_, links_.size(), i));
  return links_[i];
}

CostRule OptimalControlProblem::cost_rule(int phase) const {
  return phase_at(phase).input_shape() == InputShape::linear ? CostRule::integrated : cost_rule_;
}

OptimalControlProblem& OptimalControlProblem::total_time(Bounds bounds) {
  total_time_ = without_sentinels(bounds);
  return *this;
}

OptimalControlProblem& OptimalControlProblem::append(Jump jump, const PhaseDefinition& phase) {
  jumps_.push_back(std::move(jump));
  phases_.push_back(phase);
  return *this;
}

OptimalControlProblem& OptimalControlProblem::close(Jump jump) {
  closing_ = std::move(jump);
  return *this;
}

OptimalControlProblem OptimalControlProblem::after(int phases) const {
  if (phases < 0 || phases >= static_cast<int>(phases_.size()))
    throw DefinitionError(
        fmt::format("problem '{}' has {} phases, so none remains after removing {}", name_,
                    phases_.size(), phases));
  if (phases == 0) return *this;
  if (closing_)
    throw DefinitionError(fmt::format(
        "problem '{}' is closed with close(), so its first phases cannot be removed", name_));
  std::set<std::string> begun;
  for (int j = 0; j < phases; ++j)
    for (const IntegralConstraint& integral : phases_[j].integrals) begun.insert(integral.name);
  for (std::size_t j = phases; j < phases_.size(); ++j)
    for (const IntegralConstraint& integral : phases_[j].integrals)
      if (begun.contains(integral.name))
        throw DefinitionError(
            fmt::format("problem '{}': integral '{}' continues from removed phases, so its value "
                        "at the start is unknown",
                        name_, integral.name));
  OptimalControlProblem rest = *this;
  std::erase_if(rest.links_, [&](const Link& link) {
    int over = 0;
    for (const Link::End& end : link.ends) over += phase_index(end.phase) < phases ? 1 : 0;
    if (over > 0 && over < static_cast<int>(link.ends.size()))
      throw DefinitionError(fmt::format(
          "problem '{}': link '{}' couples removed and remaining phases", name_, link.name));
    return over > 0;
  });
  // An unknown keeps its bounds from removed phases.
  for (PhaseDefinition& phase : rest.phases_)
    for (PhaseDefinition::ParameterBlock& block : phase.parameters)
      for (int i = 0; block.unknown && i < block.value.size(); ++i)
        block.bounds[i] = bounds_of_unknown(block.name, i);
  rest.phases_.erase(rest.phases_.begin(), rest.phases_.begin() + phases);
  rest.jumps_.erase(rest.jumps_.begin(), rest.jumps_.begin() + phases);
  // An equality remains an equality, because the removed phases have known durations.
  double begin = start_time_, shortest = 0.0, longest = 0.0;
  for (int j = 0; j < phases; ++j) {
    const PhaseDefinition& over = phases_[j];
    shortest += over.duration.lower;
    longest += over.duration.upper;
    begin += over.has_free_duration() ? over.duration_guess : over.duration.lower;
  }
  rest.start_time_ = begin;
  rest.start_time_bounds_.reset();
  if (total_time_.is_equality()) {
    double least = 0.0, most = 0.0;
    for (const PhaseDefinition& left : rest.phases_) {
      least += left.duration.lower;
      most += left.duration.upper;
    }
    rest.total_time_ = exactly(std::clamp(total_time_.lower - (begin - start_time_), least, most));
  } else {
    rest.total_time_ = {total_time_.lower - longest, total_time_.upper - shortest};
  }
  const PhaseDefinition& first = rest.phases_.front();
  return rest.start_at(first.state_guess.is_given() ? first.state_guess.at(0.0)
                                                    : VectorXd(VectorXd::Zero(first.sizes.nx)));
}

bool OptimalControlProblem::set_penalty_weight(std::string_view weight_name, double weight) {
  bool found = false;
  for (PhaseDefinition& phase : phases_)
    for (Term& term : phase.terms)
      if (term.soft && term.soft->name == weight_name) {
        term.soft->weight = weight;
        found = true;
      }
  const auto set = [&](Limits& limits) {
    if (!limits.soft || limits.soft->name != weight_name) return;
    limits.soft->weight = weight;
    found = true;
  };
  for (PhaseDefinition& phase : phases_)
    for (IntegralConstraint& integral : phase.integrals) set(integral.limits);
  for (Link& link : links_) set(link.limits);
  return found;
}

Bounds OptimalControlProblem::bounds_of_unknown(const std::string& name, int i) const {
  Bounds all;
  for (const PhaseDefinition& phase : phases_)
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
      if (block.unknown && block.name == name) {
        if (i < 0 || i >= static_cast<int>(block.bounds.size()))
          throw DefinitionError(
              fmt::format("problem '{}': unknown '{}' has {} entries, so there is no entry {}",
                          name_, name, block.bounds.size(), i));
        all.lower = std::max(all.lower, block.bounds[i].lower);
        all.upper = std::min(all.upper, block.bounds[i].upper);
      }
  return all;
}

namespace {

void check_jump(const PhaseDefinition& from, const Jump& jump, const PhaseDefinition& to) {
  const std::string where =
      fmt::format("jump '{}' from phase '{}' to phase '{}'", jump.name, from.name, to.name);
  if (!jump.map) {
    if (from.sizes.nx != to.sizes.nx)
      throw DefinitionError(
          fmt::format("{}: the number of states changes from {} to {}, so a jump map is needed",
                      where, from.sizes.nx, to.sizes.nx));
    return;
  }
  const bool reads_other = jump.np != 0 && jump.np != from.sizes.np;
  if (jump.nx != from.sizes.nx || reads_other)
    throw DefinitionError(
        fmt::format("{}: it takes {} states and {} parameters, but the phase before it has {} "
                    "states and {} parameters",
                    where, jump.nx, jump.np, from.sizes.nx, from.sizes.np));
  if (jump.map.outputs() != to.sizes.nx)
    throw DefinitionError(fmt::format("{}: it returns {} states, but the phase after it has {}",
                                      where, jump.map.outputs(), to.sizes.nx));
}

void check_instant(const PhaseDefinition& phase, const std::optional<Instant>& instant,
                   const Schedule& schedule, const std::string& what) {
  if (!instant) return;
  try {
    if (instant->is_event())
      schedule.index_of(instant->event());
    else if (std::isnan(instant->seconds()))
      throw DefinitionError("the window has a limit that is NaN");
  } catch (const DefinitionError& e) {
    throw DefinitionError(fmt::format("phase '{}', {}: {}", phase.name, what, e.what()));
  }
}

// Events may move but must not change their order.
void check_order(const PhaseDefinition& phase, const Window& window, const Schedule& schedule,
                 const std::string& what) {
  if (!window.from || !window.to || !window.from->is_event() || !window.to->is_event()) return;
  const std::string &from = window.from->event(), &to = window.to->event();
  if (schedule.index_of(from) >= schedule.index_of(to))
    throw DefinitionError(
        fmt::format("phase '{}', {}: the window from event '{}' to event '{}' is always empty, "
                    "because the schedule has them in the opposite order",
                    phase.name, what, from, to));
}

// Limits in phase time do not depend on the start.
void check_reach(const PhaseDefinition& phase, const Window& window, const std::string& what) {
  if (window.clock != Clock::phase) return;
  const double longest = phase.duration.upper;
  const double latest = window.to ? longest - same_instant : longest;  // `to` excludes the end
  if (window.from && !window.from->is_event() && window.from->seconds() > latest)
    throw DefinitionError(
        fmt::format("phase '{}', {}: the window begins at {} s, but the phase lasts at most {} s",
                    phase.name, what, window.from->seconds(), longest));
  if (window.to && !window.to->is_event() && window.to->seconds() < same_instant)
    throw DefinitionError(
        fmt::format("phase '{}', {}: the window ends at {} s, before the phase begins", phase.name,
                    what, window.to->seconds()));
}

void check_window(const PhaseDefinition& phase, const Window& window, const Schedule& schedule,
                  const std::string& what) {
  check_instant(phase, window.from, schedule, what);
  check_instant(phase, window.to, schedule, what);
  try {
    schedule.mask_of(window.modes);
  } catch (const DefinitionError& e) {
    throw DefinitionError(fmt::format("phase '{}', {}: {}", phase.name, what, e.what()));
  }
  if (window.from && window.to && !window.from->is_event() && !window.to->is_event() &&
      !(window.from->seconds() < window.to->seconds()))
    throw DefinitionError(fmt::format("phase '{}', {}: the window [{}, {}) s is empty", phase.name,
                                      what, window.from->seconds(), window.to->seconds()));
  check_order(phase, window, schedule, what);
  check_reach(phase, window, what);
}

}  // namespace

OptimalControlProblem::OptimalControlProblem(const OptimalControlProblem& other) = default;
OptimalControlProblem::OptimalControlProblem(OptimalControlProblem&& other) noexcept = default;
OptimalControlProblem& OptimalControlProblem::operator=(const OptimalControlProblem& other) =
    default;
OptimalControlProblem& OptimalControlProblem::operator=(OptimalControlProblem&& other) noexcept =
    default;
OptimalControlProblem::~OptimalControlProblem() = default;
OptimalControlProblem::OptimalControlProblem(std::string name) : name_(std::move(name)) {}

void OptimalControlProblem::check() const {
  if (phases_.empty())
    throw DefinitionError(fmt::format("problem '{}' has no phase; add one with then()", name_));
  Bounds start = start_time_bounds_.value_or(exactly(start_time_));  // start time of each phase, s
  for (const PhaseDefinition& phase : phases_) {
    phase.check(start);
    start = {start.lower + phase.duration.lower, start.upper + phase.duration.upper};
    for (const Term& term : phase.terms)
      check_window(phase, term.window, schedule_, "term '" + term.name + "'");
    for (const PhaseDefinition::ComponentBounds& b : phase.input_bounds)
      check_window(phase, b.window, schedule_, fmt::format("input {}", b.component));
    for (const PhaseDefinition::ComponentBounds& b : phase.state_bounds)
      check_window(phase, b.window, schedule_, fmt::format("state {}", b.component));
  }
  for (std::size_t j = 1; j < phases_.size(); ++j)
    check_jump(phases_[j - 1], jumps_[j], phases_[j]);
  if (closing_) check_jump(phases_.back(), *closing_, phases_.front());

  check_start();
  check_parameters();
  check_integrals();
  check_links();
  check_times();
}

void OptimalControlProblem::check_start() const {
  const PhaseDefinition& first = phases_.front();
  if (static_cast<int>(start_bounds_.size()) != first.sizes.nx)
    throw DefinitionError(
        fmt::format("problem '{}': the start has {} entries, but phase '{}' has {} states; use "
                    "start_at() or start_within()",
                    name_, start_bounds_.size(), first.name, first.sizes.nx));
  if (start_guess_.size() != first.sizes.nx)
    throw DefinitionError(
        fmt::format("problem '{}': the guess of the start has {} entries, but phase '{}' has {} "
                    "states",
                    name_, start_guess_.size(), first.name, first.sizes.nx));
  for (int i = 0; i < first.sizes.nx; ++i) {
    const Bounds& b = start_bounds_[i];
    if (std::isnan(b.lower) || std::isnan(b.upper) || std::isnan(start_guess_[i]))
      throw DefinitionError(fmt::format("problem '{}': start state {} is NaN", name_, i));
    if (b.is_empty())
      throw DefinitionError(
          fmt::format("problem '{}': start state {} has the empty bounds [{}, {}]", name_, i,
                      b.lower, b.upper));
    if (std::abs(start_guess_[i]) >= no_bound * first.nominal_state[i])
      throw DefinitionError(
          fmt::format("problem '{}': start state {} is {:g}, which is too large: values of "
                      "{:g} and more overflow; use other units, or declare the nominal magnitude",
                      name_, i, start_guess_[i], no_bound));
    if (start_guess_[i] < b.lower || start_guess_[i] > b.upper)
      throw DefinitionError(
          fmt::format("problem '{}': the guess of start state {}, {}, lies outside its bounds [{}, "
                      "{}]",
                      name_, i, start_guess_[i], b.lower, b.upper));
  }
  const int memory = first.switching.memory;
  if (first.switching.empty() || memory < 0) return;
  const Bounds& mode = start_bounds_[memory];
  const int modes = static_cast<int>(first.switching.modes.size());
  if (mode.is_equality() &&
      !(mode.lower >= 0.0 && mode.lower < modes && mode.lower == std::floor(mode.lower)))
    throw DefinitionError(
        fmt::format("problem '{}': start state {} stores the mode of phase '{}', but it is {}, "
                    "expected a mode from 0 to {}",
                    name_, memory, first.name, mode.lower, modes - 1));
}

void OptimalControlProblem::check_parameters() const {
  struct Known {
    const PhaseDefinition::ParameterBlock* block;
    const PhaseDefinition* phase;
  };
  std::map<std::string, Known> blocks;
  for (const PhaseDefinition& phase : phases_)
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
      const auto [it, is_new] = blocks.emplace(block.name, Known{&block, &phase});
      if (is_new) continue;
      const auto& [other, other_phase] = it->second;
      if (other->value.size() != block.value.size() || other->unknown != block.unknown ||
          other->nominal != block.nominal || !std::ranges::equal(other->entries, block.entries))
        throw DefinitionError(
            fmt::format("phase '{}': parameter '{}' is declared differently in "
                        "an earlier phase",
                        phase.name, block.name));
      for (int i = 0; !block.unknown && i < block.value.size(); ++i)
        if (other->value[i] != block.value[i])
          throw DefinitionError(
              fmt::format("data '{}'{} is {} in phase '{}' and {} in phase '{}', but data with the "
                          "same name must agree: use one value, or two names",
                          block.name, block.value.size() > 1 ? fmt::format(", entry {},", i) : "",
                          other->value[i], other_phase->name, block.value[i], phase.name));
    }

  for (const auto& [name, known] : blocks)
    for (int i = 0; known.block->unknown && i < known.block->value.size(); ++i) {
      const Bounds all = bounds_of_unknown(name, i);
      if (all.is_empty())
        throw DefinitionError(
            fmt::format("parameter '{}': the bounds of entry {} in different phases contradict "
                        "each other: [{}, {}]",
                        name, i, all.lower, all.upper));
    }
}

void OptimalControlProblem::check_times() const {
  if (!std::isfinite(start_time_))
    throw DefinitionError(fmt::format(
        "problem '{}': the start time is {} s, expected a finite number", name_, start_time_));
  if (start_time_bounds_ &&
      (start_time_bounds_->is_empty() || start_time_ < start_time_bounds_->lower ||
       start_time_ > start_time_bounds_->upper))
    throw DefinitionError(
        fmt::format("problem '{}': the guess of the start time, {} s, lies outside its bounds [{}, "
                    "{}] s, or these are empty",
                    name_, start_time_, start_time_bounds_->lower, start_time_bounds_->upper));
  double shortest = 0.0, longest = 0.0;
  for (const PhaseDefinition& phase : phases_) {
    shortest += phase.duration.lower;
    longest += phase.duration.upper;
  }
  if (total_time_.is_empty() || total_time_.upper < shortest - same_instant ||
      total_time_.lower > longest + same_instant)
    throw DefinitionError(
        fmt::format("problem '{}': the total time [{}, {}] s is impossible for phases that last {} "
                    "to {} s in total",
                    name_, total_time_.lower, total_time_.upper, shortest, longest));
  // With one free duration and a fixed total time, the guard cannot determine the duration.
  const PhaseDefinition* free_phase = nullptr;
  int free_durations = 0;
  for (const PhaseDefinition& phase : phases_)
    if (phase.has_free_duration()) {
      ++free_durations;
      free_phase = &phase;
    }
  if (total_time_.is_equality() && free_durations == 1 && !free_phase->end_guards.empty())
    throw DefinitionError(fmt::format(
        "phase '{}', event '{}': the total time is fixed at {} s and no other phase has a free "
        "duration, so the event cannot end the phase",
        free_phase->name, free_phase->end_guards.front().event, total_time_.lower));
}

}  // namespace saltus
