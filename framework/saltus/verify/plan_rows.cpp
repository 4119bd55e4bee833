#include "saltus/verify/plan_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/model/steps_of.hpp"
#include "saltus/ocp/term_reads.hpp"

namespace saltus {
namespace {

constexpr int most_formula_steps = 5000;

const PhaseDefinition::Allowance* allowance_for(const PhaseDefinition& phase,
                                                const std::string& term) {
  const auto found = std::ranges::find_if(
      phase.allowances, [&](const PhaseDefinition::Allowance& a) { return a.term == term; });
  return found == phase.allowances.end() ? nullptr : &*found;
}

PathRow make_row(const PhaseDefinition& phase, const std::string& term, Bounds bounds,
                 double nominal, const GridAccuracy& accuracy) {
  bounds = without_sentinels(bounds);
  PathRow row{bounds, bound_tolerance(bounds.lower, nominal, accuracy),
              bound_tolerance(bounds.upper, nominal, accuracy), 0.0, 0.0};
  const PhaseDefinition::Allowance* given = allowance_for(phase, term);
  if (given != nullptr && given->at_nodes > 0.0)
    row.lower_at_node = row.upper_at_node = given->at_nodes;
  row.lower_between = accuracy.between_nodes * row.lower_at_node;
  row.upper_between = accuracy.between_nodes * row.upper_at_node;
  if (given != nullptr) row.lower_between = row.upper_between = given->between_nodes;
  return row;
}

// The elementary steps of a formula, if the function consists of them alone.
std::optional<FormulaBounds> bounds_of(const Function& function) {
  try {
    FormulaSteps steps = steps_of(function);
    if (steps.steps.size() > most_formula_steps) return std::nullopt;
    return FormulaBounds(std::move(steps));
  } catch (const DefinitionError&) {
    return std::nullopt;  // composed of other functions: algebraic states, external functions
  }
}

void find_arguments(PathConstraint& c) {
  for (const FormulaStep& step : c.formula ? c.formula->steps().steps : std::vector<FormulaStep>{})
    if (step.operation == Operation::input) c.arguments.push_back(static_cast<int>(step.value));
  std::ranges::sort(c.arguments);
  c.arguments.erase(std::unique(c.arguments.begin(), c.arguments.end()), c.arguments.end());
}

FormulaBounds state_itself(const Arguments& sizes, int state) {
  FormulaSteps steps;
  steps.inputs = sizes.size();
  steps.outputs = {steps.add_input(sizes.x(state))};
  return FormulaBounds(std::move(steps));
}

}  // namespace

double bound_tolerance(double bound, double nominal, const GridAccuracy& accuracy) {
  return accuracy.rows * std::max({1.0, std::isfinite(bound) ? std::abs(bound) : 0.0, nominal});
}

double beyond(double value, const Bounds& bounds) {
  if (!std::isfinite(value)) return infinity;
  return std::max({bounds.lower - value, value - bounds.upper, 0.0});
}

std::optional<PathConstraint> values_of(const Function& function) {
  PathConstraint c;
  c.function = function;
  c.formula = bounds_of(function);
  if (!c.formula) return std::nullopt;
  c.rows.assign(function.outputs(), {});
  find_arguments(c);
  return c;
}

std::vector<PathConstraint> path_constraints(const PhaseDefinition& phase,
                                             const GridAccuracy& accuracy) {
  std::vector<PathConstraint> list;
  const auto finish = [&](PathConstraint&& c) {
    find_arguments(c);
    list.push_back(std::move(c));
  };
  for (const Term& term : phase.terms) {
    if (term.kind != Term::Kind::constraint || term.domain != Term::Domain::running || term.soft)
      continue;
    if (std::ranges::all_of(term.bounds, &Bounds::is_free)) continue;
    PathConstraint c{.name = term.name, .function = term.function, .window = term.window};
    c.reads_input = reads_any(term.function, phase.sizes.u(), phase.sizes.nu);
    for (const Bounds& b : term.bounds) {
      c.rows.push_back(make_row(phase, term.name, b, 0.0, accuracy));
      c.rows.back().reads_states_alone =
          reads_states_alone(phase.sizes, term.function, static_cast<int>(c.rows.size()) - 1);
    }
    c.formula = bounds_of(term.function);
    finish(std::move(c));
  }
  for (const PhaseDefinition::ComponentBounds& b : phase.state_bounds) {
    if (b.bounds.is_free()) continue;
    PathConstraint c{.name = fmt::format("bounds of state {}", b.component),
                     .state = b.component,
                     .window = b.window};
    c.rows.push_back(make_row(phase, c.name, b.bounds, phase.nominal_state[b.component], accuracy));
    c.formula = state_itself(phase.sizes, b.component);
    finish(std::move(c));
  }
  return list;
}

bool is_open(const Window& window, const Schedule& schedule, double phase_start,
             const Plan::Interval& interval) {
  const double middle = interval.start + 0.5 * interval.length;
  const auto time_of = [&](const Instant& instant) {
    if (instant.is_event()) return schedule.time_of(instant.event());
    return instant.seconds() + (window.clock == Clock::phase ? phase_start : 0.0);
  };
  if (window.from && middle < time_of(*window.from)) return false;
  if (window.to && middle > time_of(*window.to)) return false;
  return window.modes.empty() ||
         std::ranges::find(window.modes, schedule.mode_at(middle)) != window.modes.end();
}

std::vector<VectorXd> units_of_states(const OptimalControlProblem& problem, const Plan& plan) {
  constexpr double zero = 1e-9;
  std::map<Eigen::Index, VectorXd> largest;  // by the number of states
  const auto look_at = [&](const VectorXd& x) {
    VectorXd& known =
        largest.try_emplace(x.size(), VectorXd::Constant(x.size(), zero)).first->second;
    for (int i = 0; i < x.size(); ++i)
      if (std::isfinite(x[i])) known[i] = std::max(known[i], std::abs(x[i]));
  };
  for (const Plan::Interval& interval : plan.intervals) {
    look_at(interval.state);
    look_at(interval.end_state);
  }
  std::vector<VectorXd> units;
  for (const PhaseDefinition& phase : problem.phases()) {
    const int nx = phase.sizes.nx;
    const auto found = largest.find(nx);
    VectorXd unit = found != largest.end() ? found->second : VectorXd::Ones(nx);
    for (int i = 0; i < nx; ++i) {
      const double nominal = phase.nominal_state[i];
      unit[i] = phase.has_nominal || nominal != 1.0 ? nominal : std::min(1.0, unit[i]);
    }
    units.push_back(std::move(unit));
  }
  return units;
}

}  // namespace saltus
