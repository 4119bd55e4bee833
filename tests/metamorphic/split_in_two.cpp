// The law of cuts: a phase of fixed duration becomes two phases of half its length on the same
// nodes.
#include <fmt/format.h>

#include "saltus/sequences/mode_graph.hpp"
#include "tests/metamorphic/laws.hpp"

namespace saltus::metamorphic {
namespace {

// Reason why a cut of phase j changes the problem, or empty if it does not.
std::string obstacle(const Stated& stated, int j, int intervals) {
  const PhaseDefinition& phase = stated.problem.phases()[j];
  if (phase.has_free_duration())
    return "its duration is free, so two phases would have more freedom";
  if (intervals % 2 != 0) return "its number of intervals is odd";
  if (!stated.options.meshes.empty()) return "its mesh is given";
  if (phase.input_parametrisation == InputParametrisation::piecewise_linear_continuous)
    return "its input is continuous";
  if (phase.input_change_weight.size() > 0) return "changes of its input have a cost";
  if (phase.state_guess.is_simulated()) return "its guess is simulated";
  if (!stated.problem.links().empty()) return "links refer to it";
  for (const Term& term : phase.terms)
    if (!term.window.is_whole() && term.window.clock == Clock::phase)
      return "a window in phase time";
  for (const auto* all : {&phase.state_bounds, &phase.input_bounds})
    for (const PhaseDefinition::ComponentBounds& b : *all)
      if (!b.window.is_whole() && b.window.clock == Clock::phase) return "a window in phase time";
  return {};
}

Guess half_of(const Guess& guess, double from) {
  if (!guess.is_given() || guess.is_simulated()) return guess;
  return Guess::trajectory([=](double f) { return guess.at(from + 0.5 * f); });
}

}  // namespace

std::optional<Transformed> split_in_two(const Stated& stated, const Solution&, Random& random,
                                        std::string& why) {
  const int count = static_cast<int>(stated.problem.phases().size());
  std::vector<int> intervals = stated.options.intervals;
  if (intervals.empty()) intervals.assign(count, stated.options.intervals_per_phase);
  std::vector<int> possible;
  for (int j = 0; j < count; ++j) {
    const std::string reason = obstacle(stated, j, intervals[j]);
    if (reason.empty())
      possible.push_back(j);
    else
      why = reason;
  }
  if (possible.empty()) return {};
  const int cut = possible[random.integer(0, static_cast<int>(possible.size()) - 1)];

  OptimalControlProblem problem(stated.problem.name());
  std::vector<int> new_intervals;
  for (int j = 0; j < count; ++j) {
    PhaseDefinition phase = stated.problem.phases()[j];
    const Jump& into = stated.problem.jumps()[j];
    if (j != cut) {
      problem.then(ErasedPhase(phase), into);
      new_intervals.push_back(intervals[j]);
      continue;
    }
    PhaseDefinition first = phase, second = phase;
    first.name += ", first half";
    const double half = 0.5 * phase.duration.lower;
    for (PhaseDefinition* part : {&first, &second}) part->duration = exactly(half);
    std::erase_if(first.terms, [](const Term& t) { return t.domain == Term::Domain::phase_end; });
    std::erase_if(second.terms,
                  [](const Term& t) { return t.domain == Term::Domain::phase_start; });
    first.end_guards.clear();
    for (IntegralConstraint& integral : first.integrals) integral.limits = Limits(unbounded());
    first.state_guess = half_of(phase.state_guess, 0.0);
    second.state_guess = half_of(phase.state_guess, 0.5);
    first.input_guess = half_of(phase.input_guess, 0.0);
    second.input_guess = half_of(phase.input_guess, 0.5);
    problem.then(ErasedPhase(first), into).then(ErasedPhase(second));
    new_intervals.insert(new_intervals.end(), 2, intervals[j] / 2);
  }
  if (stated.problem.closing()) problem.close(*stated.problem.closing());
  problem.start_within(stated.problem.start_bounds(), stated.problem.start_guess());
  if (stated.problem.start_time_bounds())
    problem.start_time(*stated.problem.start_time_bounds(), stated.problem.start_time());
  else
    problem.start_time(stated.problem.start_time());
  problem.schedule(stated.problem.schedule()).costs(stated.problem.cost_rule());
  problem.total_time(stated.problem.total_time());
  Transformed t{.stated = {std::move(problem), stated.options}};
  t.stated.options.intervals = new_intervals;
  t.what = fmt::format("phase {}", cut + 1);
  return t;
}

}  // namespace saltus::metamorphic
