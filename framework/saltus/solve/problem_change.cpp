#include "saltus/solve/explain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

using Kind = ProblemChange::Kind;
using Side = ProblemChange::Side;

// Applied to the number that a change refers to, in a copy of the problem.
using Visit = std::function<void(double& number, bool is_value)>;

void visit_side(Bounds& bounds, Side side, const Visit& visit) {
  if (bounds.is_equality()) {
    visit(bounds.lower, true);
    bounds.upper = bounds.lower;
  } else {
    visit(side == Side::lower ? bounds.lower : bounds.upper, false);
  }
}

// A single bound for all `rows` is expanded to one per row first.
void visit_bounds(std::vector<Bounds>& bounds, int rows, const ProblemChange& change,
                  const Visit& visit) {
  if (bounds.size() == 1) bounds.resize(static_cast<std::size_t>(rows), bounds.front());
  const auto i = static_cast<std::size_t>(change.component);
  if (i < bounds.size()) visit_side(bounds[i], change.side, visit);
}

void visit_component(std::vector<PhaseDefinition::ComponentBounds>& all,
                     const ProblemChange& change, const Visit& visit) {
  for (PhaseDefinition::ComponentBounds& b : all)
    if (b.component == change.component) visit_side(b.bounds, change.side, visit);
}

void visit_parameter(OptimalControlProblem& problem, const ProblemChange& change,
                     const Visit& visit) {
  // blocks with one name are one parameter
  for (std::size_t j = 0; j < problem.phases().size(); ++j)
    for (PhaseDefinition::ParameterBlock& block :
         problem.editable_phase(static_cast<int>(j)).parameters) {
      if (block.name != change.name || change.component >= block.value.size()) continue;
      if (block.unknown) {
        visit_bounds(block.bounds, static_cast<int>(block.value.size()), change, visit);
        const Bounds& moved = block.bounds[change.component];
        double& guess = block.value[change.component];
        guess = std::min(std::max(guess, moved.lower), moved.upper);
      } else {
        visit(block.value[change.component], true);
      }
    }
}

void visit_start(OptimalControlProblem& problem, const ProblemChange& change, const Visit& visit) {
  std::vector<Bounds> bounds = problem.start_bounds();
  VectorXd guess = problem.start_guess();
  Bounds& moved = bounds.at(change.component);
  const bool is_given = moved.is_equality();
  visit_side(moved, change.side, visit);
  double& begin = guess[change.component];
  begin = is_given ? moved.lower : std::min(std::max(begin, moved.lower), moved.upper);
  problem.start_within(std::move(bounds), std::move(guess));
}

void visit_number(OptimalControlProblem& problem, const ProblemChange& change, const Visit& visit) {
  const int j = std::clamp(change.phase, 0, static_cast<int>(problem.phases().size()) - 1);
  PhaseDefinition& phase = problem.editable_phase(j);
  switch (change.kind) {
    case Kind::term:
      for (Term& term : phase.terms)
        if (term.kind == Term::Kind::constraint && term.name == change.name)
          visit_bounds(term.bounds, term.function.outputs(), change, visit);
      return;
    case Kind::state:
      return visit_component(phase.state_bounds, change, visit);
    case Kind::input:
      return visit_component(phase.input_bounds, change, visit);
    case Kind::integral:
      for (IntegralConstraint& integral : phase.integrals)
        if (integral.name == change.name) visit_bounds(integral.limits.bounds, 1, change, visit);
      return;
    case Kind::link:
      for (std::size_t l = 0; l < problem.links().size(); ++l)
        if (problem.links()[l].name == change.name)
          visit_bounds(problem.editable_link(static_cast<int>(l)).limits.bounds,
                       problem.links()[l].function.outputs(), change, visit);
      return;
    case Kind::duration:
      visit_side(phase.duration, change.side, visit);
      if (phase.has_free_duration())
        phase.duration_guess =
            std::clamp(phase.duration_guess, phase.duration.lower, phase.duration.upper);
      return;
    case Kind::total_time: {
      Bounds total = problem.total_time();
      visit_side(total, change.side, visit);
      problem.total_time(total);
      return;
    }
    case Kind::event: {
      if (!problem.schedule().contains(change.name)) return;
      double time = problem.schedule().time_of(change.name);
      visit(time, true);
      problem.editable_schedule().retime(change.name, time);
      return;
    }
    case Kind::parameter:
      return visit_parameter(problem, change, visit);
    case Kind::start:
      return visit_start(problem, change, visit);
  }
}

// "'tick.com'[1]", or "'slope'" for a single number.
std::string name_of_entry(const OptimalControlProblem& problem, const ProblemChange& change) {
  for (const PhaseDefinition& phase : problem.phases())
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
      if (block.name != change.name) continue;
      for (const ParameterEntry& entry : block.entries) {
        const int i = change.component - entry.first;
        if (i < 0 || i >= entry.size()) continue;
        return fmt::format("'{}.{}'{}", block.name, entry.name,
                           entry.size() > 1 ? fmt::format("[{}]", i) : "");
      }
      if (block.value.size() == 1) return fmt::format("'{}'", block.name);
    }
  return fmt::format("'{}'[{}]", change.name, change.component);
}

std::string name_of(const OptimalControlProblem& problem, const ProblemChange& change) {
  const PhaseDefinition& phase =
      problem.phases()[std::clamp(change.phase, 0, static_cast<int>(problem.phases().size()) - 1)];
  const auto row = [&](std::size_t rows) {
    return rows > 1 ? fmt::format(", row {}", change.component) : std::string();
  };
  switch (change.kind) {
    case Kind::term: {
      const auto term = std::ranges::find(phase.terms, change.name, &Term::name);
      return fmt::format("'{}'{} of phase '{}'", change.name,
                         row(term == phase.terms.end() ? 1 : term->bounds.size()), phase.name);
    }
    case Kind::state:
      return fmt::format("state {} in phase '{}'", change.component, phase.name);
    case Kind::input:
      return fmt::format("input {} in phase '{}'", change.component, phase.name);
    case Kind::integral:
      return fmt::format("integral '{}' of phase '{}'", change.name, phase.name);
    case Kind::link: {
      const auto link = std::ranges::find(problem.links(), change.name, &Link::name);
      return fmt::format(
          "link '{}'{}", change.name,
          row(link == problem.links().end() ? 1
                                            : static_cast<std::size_t>(link->function.outputs())));
    }
    case Kind::duration:
      return fmt::format("the duration of phase '{}'", phase.name);
    case Kind::total_time:
      return "the total time";
    case Kind::event:
      return fmt::format("event '{}'", change.name);
    case Kind::parameter:
      return name_of_entry(problem, change);
    case Kind::start:
      return fmt::format("state {} at the start", change.component);
  }
  return {};
}

// Current value of the number: the tightest of several windows, and whether both sides are equal.
struct Number {
  double value = 0.0;
  bool is_value = false;
};

Number number_of(const OptimalControlProblem& problem, const ProblemChange& change) {
  OptimalControlProblem copy = problem;
  std::vector<Number> all;
  visit_number(copy, change, [&](double& number, bool is_value) {
    all.push_back({number, is_value});
  });
  if (all.empty())
    throw DefinitionError(fmt::format("problem '{}' has no {} that could change", problem.name(),
                                      name_of(problem, change)));
  return change.side == Side::lower ? std::ranges::max(all, {}, &Number::value)
                                    : std::ranges::min(all, {}, &Number::value);
}

}  // namespace

const char* describe(Kind kind) {
  switch (kind) {
    case Kind::term:
      return "term";
    case Kind::state:
      return "state";
    case Kind::input:
      return "input";
    case Kind::integral:
      return "integral";
    case Kind::link:
      return "link";
    case Kind::duration:
      return "duration";
    case Kind::total_time:
      return "total time";
    case Kind::event:
      return "event";
    case Kind::parameter:
      return "parameter";
    case Kind::start:
      return "start";
  }
  return "unknown";
}

OptimalControlProblem changed(const OptimalControlProblem& problem, const ProblemChange& change) {
  OptimalControlProblem result = problem;
  bool is_there = false;
  visit_number(result, change, [&](double& number, bool) {
    is_there = true;
    number += change.by;
  });
  if (!is_there)
    throw DefinitionError(fmt::format("problem '{}' has no {} that could change", problem.name(),
                                      name_of(problem, change)));
  return result;
}

double value_before(const OptimalControlProblem& problem, const ProblemChange& change) {
  return number_of(problem, change).value;
}

std::string describe(const OptimalControlProblem& problem, const ProblemChange& change) {
  const auto [before, is_value] = number_of(problem, change);
  const bool is_time = change.kind == Kind::duration || change.kind == Kind::total_time ||
                       change.kind == Kind::event;
  const char* unit = is_time ? " s" : "";
  const std::string name = name_of(problem, change);
  if (change.kind == Kind::event)
    return fmt::format("with {} {:.3g} s {} (at {:.4g} s)", name, std::abs(change.by),
                       change.by < 0.0 ? "earlier" : "later", before + change.by);
  if (is_value)
    return fmt::format("with {} {:.4g}{} instead of {:.4g}{}", name, before + change.by, unit,
                       before, unit);
  return fmt::format("with {} allowed {} {:.4g}{} instead of {:.4g}{}", name,
                     change.side == Side::lower ? "down to" : "up to", before + change.by, unit,
                     before, unit);
}

}  // namespace saltus
