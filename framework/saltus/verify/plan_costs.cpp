#include "saltus/verify/plan_costs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "saltus/ocp/cost_functions.hpp"
#include "saltus/ocp/term_reads.hpp"
#include "saltus/verify/plan_rows.hpp"

namespace saltus {
namespace {

std::vector<const Plan::Interval*> intervals_of(const Plan& plan, int phase) {
  std::vector<const Plan::Interval*> list;
  for (const Plan::Interval& interval : plan.intervals)
    if (interval.phase == phase) list.push_back(&interval);
  return list;
}

// Violation that solvers leave of a satisfied row, relative to the largest of 1 and its sides. A
// weight of 1e10 would turn it into a cost.
constexpr double held = 1e-8;

double penalty_of(const Penalty& penalty, const VectorXd& values,
                  const std::vector<Bounds>& bounds) {
  double paid = 0.0;
  for (int i = 0; i < values.size(); ++i) {
    const Bounds& b = bounds[bounds.size() > 1 ? i : 0];
    double size = 1.0;
    for (const double side : {b.lower, b.upper})
      if (std::isfinite(side)) size = std::max(size, std::abs(side));
    const double violation = beyond(values[i], b);
    if (!(violation <= held * size)) paid += cost(penalty, violation);
  }
  return paid;
}

bool has_given_start(const OptimalControlProblem& problem) {
  return std::ranges::all_of(problem.start_bounds(), &Bounds::is_equality);
}

// A running penalty counts per unit of time. A node counts for the interval that starts there, and
// the last node of a window for the interval that ends there. Rows with a linear input share an
// interval between both ends.
double running_penalty(const OptimalControlProblem& problem, const Plan& plan, int j,
                       const Term& term) {
  const PhaseDefinition& phase = problem.phases()[j];
  const bool of_input = reads_any(term.function, phase.sizes.u(), phase.sizes.nu);
  const bool is_linear = phase.input_shape() == InputShape::linear;
  const std::vector<const Plan::Interval*> all = intervals_of(plan, j);
  double paid = 0.0;
  const auto charge = [&](const Plan::Interval& at, bool at_end, double time) {
    const VectorXd z = argument_of(phase.sizes, at, at_end, plan.parameters[j]);
    paid += time * penalty_of(*term.soft, term.function(z), term.bounds);
  };
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Plan::Interval& here = *all[k];
    const auto open = [&](const Plan::Interval& i) {
      return is_open(term.window, problem.schedule(), plan.starts[j], i);
    };
    if (!open(here)) continue;
    if (of_input) {
      charge(here, false, (is_linear ? 0.5 : 1.0) * here.length);
      if (is_linear) charge(here, true, 0.5 * here.length);
      continue;
    }
    const bool is_given = j == 0 && k == 0 && has_given_start(problem);
    if (!is_given) charge(here, false, here.length);
    if (k + 1 == all.size() || !open(*all[k + 1])) charge(here, true, here.length);
  }
  return paid;
}

VectorXd link_argument(const OptimalControlProblem& problem, const Plan& plan, const Link& link,
                       int& phase, double& time) {
  VectorXd z = VectorXd::Zero(link.function.inputs());
  int next = 1;
  phase = 0;
  time = plan.starts.front();
  for (const Link::End& end : link.ends) {
    const int j = problem.phase_index(end.phase);
    const std::vector<const Plan::Interval*> all = intervals_of(plan, j);
    const double t = plan.starts[j] + (end.is_end ? plan.durations[j] : 0.0);
    if (t >= time) time = t, phase = j;
    z[next] = t;
    z[next + 1] = plan.durations[j];
    if (!all.empty())
      z.segment(next + 2, end.nx) = end.is_end ? all.back()->end_state : all.front()->state;
    z.segment(next + 2 + end.nx, end.np) = plan.parameters[j].head(end.np);
    next += end.size();
  }
  return z;
}

// Values of the integrals of each name at the end of each phase that declares it.
std::vector<std::vector<double>> integrals_so_far(const OptimalControlProblem& problem,
                                                  const std::vector<PhaseTotals>& totals) {
  std::map<std::string, double> reached;
  std::vector<std::vector<double>> list;
  for (std::size_t j = 0; j < problem.phases().size(); ++j) {
    auto& of_phase = list.emplace_back();
    const PhaseDefinition& phase = problem.phases()[j];
    for (std::size_t i = 0; i < phase.integrals.size(); ++i)
      of_phase.push_back(reached[phase.integrals[i].name] += totals[j].integrals[i]);
  }
  return list;
}

}  // namespace

VectorXd argument_of(const Arguments& sizes, const Plan::Interval& interval, bool at_end,
                     const VectorXd& parameters) {
  VectorXd z(sizes.size());
  z << (at_end ? interval.end() : interval.start), (at_end ? interval.end_state : interval.state),
      (at_end ? interval.coefficients.tail(sizes.nu) : interval.coefficients.head(sizes.nu)),
      parameters;
  return z;
}

PlanCost cost_of(const OptimalControlProblem& problem, const Plan& plan,
                 const std::vector<PhaseTotals>& totals) {
  PlanCost result;
  const auto add = [&](double part) {
    result.value += part;
    result.magnitude += std::abs(part);
  };
  for (int j = 0; j < static_cast<int>(problem.phases().size()); ++j) {
    const PhaseDefinition& phase = problem.phases()[j];
    const std::vector<const Plan::Interval*> all = intervals_of(plan, j);
    for (std::size_t t = 0; t < phase.terms.size() && !all.empty(); ++t) {
      const Term& term = phase.terms[t];
      if (term.kind == Term::Kind::constraint) {
        if (!term.soft) continue;
        if (term.domain == Term::Domain::running) {
          add(running_penalty(problem, plan, j, term));
          continue;
        }
        const bool at_end = term.domain == Term::Domain::phase_end;
        const VectorXd z = argument_of(phase.sizes, at_end ? *all.back() : *all.front(), at_end,
                                       plan.parameters[j]);
        add(penalty_of(*term.soft, term.function(z), term.bounds));
        continue;
      }
      const Function function = cost_function(term);
      if (term.domain != Term::Domain::running) {
        const bool at_end = term.domain == Term::Domain::phase_end;
        add(function(argument_of(phase.sizes, at_end ? *all.back() : *all.front(), at_end,
                                 plan.parameters[j]))[0]);
      } else if (problem.cost_rule(j) == CostRule::integrated) {
        add(totals[j].costs[t]);
      } else {
        double sum = 0.0;
        for (const Plan::Interval* i : all)
          if (i->length > 0.0 && is_open(term.window, problem.schedule(), plan.starts[j], *i))
            sum += i->length * function(argument_of(phase.sizes, *i, false, plan.parameters[j]))[0];
        add(sum);
      }
    }
  }
  const auto so_far = integrals_so_far(problem, totals);
  for (std::size_t j = 0; j < problem.phases().size(); ++j)
    for (std::size_t i = 0; i < problem.phases()[j].integrals.size(); ++i) {
      const Limits& limits = problem.phases()[j].integrals[i].limits;
      if (limits.soft)
        add(penalty_of(*limits.soft, VectorXd::Constant(1, so_far[j][i]), limits.bounds));
    }
  for (const Link& link : problem.links()) {
    if (!link.limits.soft && !link.is_cost) continue;
    int phase = 0;
    double time = 0.0;
    const VectorXd value = link.function(link_argument(problem, plan, link, phase, time));
    add(link.is_cost ? value[0] : penalty_of(*link.limits.soft, value, link.limits.bounds));
  }
  return result;
}

namespace {

// Records each row of `values` that exceeds its bounds.
void note_rows(const VectorXd& values, const std::vector<Bounds>& bounds, double nominal,
               double given_tolerance, const GridAccuracy& accuracy,
               const Verification::Miss& where, const NoteMiss& note) {
  for (int i = 0; i < values.size(); ++i) {
    const Bounds& b = bounds[bounds.size() > 1 ? i : 0];
    Verification::Miss miss = where;
    miss.amount = beyond(values[i], b);
    const double bound = values[i] < b.lower ? b.lower : b.upper;
    miss.tolerance =
        given_tolerance > 0.0 ? given_tolerance : bound_tolerance(bound, nominal, accuracy);
    if (miss.amount > 0.0) note(std::move(miss));
  }
}

double allowed_for(const PhaseDefinition& phase, const std::string& term) {
  for (const PhaseDefinition::Allowance& a : phase.allowances)
    if (a.term == term) return a.at_nodes > 0.0 ? a.at_nodes : a.between_nodes;
  return 0.0;
}

}  // namespace

void check_end_terms(const OptimalControlProblem& problem, const Plan& plan, int j,
                     const VectorXd& end_state, const GridAccuracy& accuracy,
                     const NoteMiss& note) {
  const PhaseDefinition& phase = problem.phases()[j];
  const std::vector<const Plan::Interval*> all = intervals_of(plan, j);
  if (all.empty()) return;
  for (const Term& term : phase.terms) {
    if (term.kind != Term::Kind::constraint || term.soft || term.domain == Term::Domain::running)
      continue;
    const bool at_end = term.domain == Term::Domain::phase_end;
    const Plan::Interval& at = at_end ? *all.back() : *all.front();
    VectorXd z = argument_of(phase.sizes, at, at_end, plan.parameters[j]);
    if (end_state.size() > 0) {
      if (!at_end) continue;
      z.segment(phase.sizes.x(), phase.sizes.nx) = end_state;
    }
    note_rows(term.function(z), term.bounds, 0.0, allowed_for(phase, term.name), accuracy,
              {.phase = phase.name, .term = term.name, .time = at_end ? at.end() : at.start}, note);
  }
}

void check_instants(const OptimalControlProblem& problem, const Plan& plan,
                    const std::vector<PhaseTotals>& totals, const GridAccuracy& accuracy,
                    const NoteMiss& note) {
  const int phases = static_cast<int>(problem.phases().size());
  const auto check_states = [&](const VectorXd& values, const VectorXd& wanted,
                                const PhaseDefinition& phase, const std::string& term, double t) {
    for (int i = 0; i < values.size(); ++i)
      note_rows(values.segment(i, 1), {exactly(wanted[i])}, phase.nominal_state[i], 0.0, accuracy,
                {.phase = phase.name, .term = term, .time = t}, note);
  };
  const Plan::Interval& first = plan.intervals.front();
  const PhaseDefinition& first_phase = problem.phases()[first.phase];
  for (int i = 0; first.phase == 0 && i < first_phase.sizes.nx; ++i)
    note_rows(first.state.segment(i, 1), {problem.start_bounds()[i]}, first_phase.nominal_state[i],
              0.0, accuracy,
              {.phase = first_phase.name,
               .term = fmt::format("start of state {}", i),
               .time = first.start},
              note);
  if (problem.start_time_bounds())
    note_rows(VectorXd::Constant(1, plan.starts.front()), {*problem.start_time_bounds()}, 0.0, 0.0,
              accuracy, {.term = "start time", .time = plan.starts.front()}, note);
  double total = 0.0;
  const Plan::Interval* before = nullptr;
  for (int j = 0; j < phases; ++j) {
    const PhaseDefinition& phase = problem.phases()[j];
    const std::vector<const Plan::Interval*> all = intervals_of(plan, j);
    total += plan.durations[j];
    note_rows(VectorXd::Constant(1, plan.durations[j]), {phase.duration}, phase.nominal_duration,
              0.0, accuracy, {.phase = phase.name, .term = "duration", .time = plan.starts[j]},
              note);
    int p = 0;
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
      for (int i = 0; i < block.value.size(); ++i, ++p)
        if (block.unknown)
          note_rows(plan.parameters[j].segment(p, 1), {problem.bounds_of_unknown(block.name, i)},
                    block.nominal[i], 0.0, accuracy,
                    {.phase = phase.name,
                     .term = fmt::format("parameter '{}'", block.name),
                     .time = plan.starts[j]},
                    note);
    check_end_terms(problem, plan, j, {}, accuracy, note);
    if (all.empty()) continue;
    if (before != nullptr && before->phase == j - 1) {
      const Jump& jump = problem.jumps()[j];
      check_states(all.front()->state,
                   jump.apply(before->end(), before->end_state, plan.parameters[j - 1]), phase,
                   fmt::format("jump '{}'", jump.name), before->end());
    }
    before = all.back();
    for (const PhaseDefinition::ComponentBounds& b : phase.input_bounds)
      for (const Plan::Interval* i : all) {
        if (!(i->length > 0.0) || !is_open(b.window, problem.schedule(), plan.starts[j], *i))
          continue;
        for (const bool at_end : {false, true}) {
          if (at_end && phase.input_shape() == InputShape::constant) continue;
          const auto c = at_end ? phase.sizes.nu + b.component : b.component;
          note_rows(i->coefficients.segment(c, 1), {b.bounds}, phase.nominal_input[b.component],
                    0.0, accuracy,
                    {.phase = phase.name,
                     .term = fmt::format("bounds of input {}", b.component),
                     .time = at_end ? i->end() : i->start},
                    note);
        }
      }
  }
  note_rows(VectorXd::Constant(1, total), {problem.total_time()}, 0.0, 0.0, accuracy,
            {.term = "total time", .time = plan.starts.front() + total}, note);
  if (problem.closing() && before != nullptr)
    check_states(first.state,
                 problem.closing()->apply(before->end(), before->end_state, plan.parameters.back()),
                 first_phase, "closing", before->end());
  const auto so_far = integrals_so_far(problem, totals);
  for (int j = 0; j < phases; ++j) {
    const PhaseDefinition& phase = problem.phases()[j];
    for (std::size_t i = 0; i < phase.integrals.size(); ++i) {
      const IntegralConstraint& integral = phase.integrals[i];
      if (integral.limits.soft) continue;
      note_rows(VectorXd::Constant(1, so_far[j][i]), integral.limits.bounds,
                std::max(integral.magnitude, std::abs(so_far[j][i])), 0.0, accuracy,
                {.phase = phase.name,
                 .term = fmt::format("integral '{}'", integral.name),
                 .time = plan.starts[j] + plan.durations[j]},
                note);
    }
  }
  for (const Link& link : problem.links()) {
    if (link.limits.soft || link.is_cost) continue;
    int phase = 0;
    double time = 0.0;
    const VectorXd z = link_argument(problem, plan, link, phase, time);
    note_rows(link.function(z), link.limits.bounds, 0.0, 0.0, accuracy,
              {.phase = problem.phases()[phase].name,
               .term = fmt::format("link '{}'", link.name),
               .time = time},
              note);
  }
}

}  // namespace saltus
