#include "tests/metamorphic/laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/sequences/mode_graph.hpp"
#include "tests/metamorphic/scaled_function.hpp"

namespace saltus::metamorphic {
namespace {

using Result = std::optional<Transformed>;

Transformed same_answer(const Stated& stated, OptimalControlProblem problem) {
  return {.stated = {std::move(problem), stated.options}};
}

// The cost changes as the multipliers of the start predict, up to second-order terms.
Result start_moved(const Stated& stated, const Solution& base, Random& random, std::string& why) {
  const auto& bounds = stated.problem.start_bounds();
  const int memory = stated.problem.phases()[0].switching.memory;  // the number of a mode
  std::vector<int> given;
  bool is_given = true;
  for (int i = 0; i < static_cast<int>(bounds.size()); ++i) {
    is_given = is_given && bounds[i].is_equality();
    if (i != memory) given.push_back(i);
  }
  if (!is_given || given.empty() || stated.problem.closing()) {
    why = "the start is free";
    return {};
  }
  if (!base.ok() || base.start_multipliers.size() != static_cast<int>(bounds.size())) {
    why = "no derivative of the cost is known";
    return {};
  }
  const int i = given[random.integer(0, static_cast<int>(given.size()) - 1)];
  const double unit = stated.problem.phases()[0].nominal_state.size() > i
                          ? stated.problem.phases()[0].nominal_state[i]
                          : 1.0;
  const double by = random.log_uniform(1e-12, 1e-2) * unit * (random.chance(0.5) ? 1.0 : -1.0);
  VectorXd start = stated.problem.start_guess();
  start[i] += by;
  OptimalControlProblem moved = stated.problem;
  moved.start_at(start);
  Transformed t = same_answer(stated, std::move(moved));
  t.moved_state = i;
  t.moved_by = by;
  t.is_same_plan = false;
  t.what = fmt::format("state {} by {:.2g}", i, by);
  return t;
}

Result idle_bounds(const Stated& stated, const Solution&, Random& random, std::string&) {
  const double size = random.log_uniform(1e3, 1e30);
  const int which = random.integer(1, 7);
  Transformed t = same_answer(
      stated, rebuilt(stated.problem, [&](int, PhaseDefinition& phase) {
        const auto beyond = [&](double nominal) {
          return between(-size * nominal, size * nominal);
        };
        // Inactive for every plan of the library, whose numbers are below a hundred times their
        // magnitudes.
        if (which & 1)
          for (int i = 0; i < phase.sizes.nx; ++i)
            phase.state_bounds.push_back({i, beyond(1e3 * phase.nominal_state[i])});
        if (which & 2)
          for (int i = 0; i < phase.sizes.nu; ++i)
            phase.input_bounds.push_back({i, beyond(1e3 * phase.nominal_input[i])});
        if ((which & 4) && phase.sizes.nx > 0) {
          add_constraint(phase, "idle", Term::Domain::running,
                         affine(VectorXd::Unit(phase.sizes.size(), phase.sizes.x(0)), 0.0),
                         {beyond(1e3 * phase.nominal_state[0])}, {}, std::nullopt);
        }
      }));
  t.what = fmt::format("size {:.2g}, kinds {}", size, which);
  return t;
}

Result ends_softened(const Stated& stated, const Solution& base, Random& random, std::string& why) {
  double scale = 1.0;
  for (const Term& term : stated.problem.phases().back().terms)
    for (const Bounds& b : term.bounds)
      for (const double side : {b.lower, b.upper})
        if (std::isfinite(side)) scale = std::max(scale, 1.0 / std::max(1e-3, std::abs(side)));
  // Larger than all multipliers in the library.
  const double weight = random.log_uniform(1e8, 1e14);
  int softened = 0;
  Transformed t =
      same_answer(stated, rebuilt(stated.problem, [&](int, PhaseDefinition& phase) {
                    for (Term& term : phase.terms) {
                      const bool is_guard =
                          std::any_of(phase.end_guards.begin(), phase.end_guards.end(),
                                      [&](const EndGuard& g) { return g.event == term.name; });
                      if (term.kind == Term::Kind::constraint &&
                          term.domain == Term::Domain::phase_end && !term.soft && !is_guard) {
                        term.soft = soft("", weight);
                        ++softened;
                      }
                    }
                  }));
  if (softened == 0 || !base.ok()) {
    why = "no phase has end constraints";
    return {};
  }
  t.what = fmt::format("L1 weight {:.2g}", weight);
  return t;
}

Result constant_rows(const Stated& stated, const Solution&, Random& random, std::string&) {
  const double beyond = random.log_uniform(1.0, 1e6);
  Transformed t = same_answer(
      stated, rebuilt(stated.problem, [&](int, PhaseDefinition& phase) {
        const int n = phase.sizes.size();
        const double last = 1e3 * (1.0 + std::abs(stated.problem.start_time())) + 1e6;
        for (const Term::Domain domain : {Term::Domain::running, Term::Domain::phase_end}) {
          const std::string where = domain == Term::Domain::running ? "" : " at the end";
          add_constraint(phase, "of time alone" + where, domain,
                         affine(VectorXd::Unit(n, phase.sizes.t()), 0.0),
                         {between(-last * beyond, last * beyond)}, {}, std::nullopt);
          int i = 0;
          for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
            if (!block.unknown && block.value.size() > 0) {
              const double value = block.value[0];
              add_constraint(phase, "of '" + block.name + "' alone" + where, domain,
                             affine(VectorXd::Unit(n, phase.sizes.p(i)), 0.0),
                             {between(value - beyond, value + beyond)}, {}, std::nullopt);
            }
            i += static_cast<int>(block.value.size());
          }
          add_constraint(phase, "of nothing" + where, domain, affine(VectorXd::Zero(n), 0.0),
                         {at_most(beyond)}, {}, std::nullopt);
        }
      }));
  t.what = fmt::format("met by {:.2g}", beyond);
  return t;
}

Result written_twice(const Stated& stated, const Solution&, Random&, std::string& why) {
  int doubled = 0;
  Transformed t =
      same_answer(stated, rebuilt(stated.problem, [&](int, PhaseDefinition& phase) {
                    for (auto* bounds : {&phase.state_bounds, &phase.input_bounds}) {
                      const std::vector<PhaseDefinition::ComponentBounds> once = *bounds;
                      doubled += static_cast<int>(once.size());
                      bounds->insert(bounds->end(), once.begin(), once.end());
                    }
                    const std::vector<Term> once = phase.terms;
                    for (Term term : once) {
                      if (term.kind != Term::Kind::constraint || term.soft) continue;
                      const std::string name = term.name + ", again";
                      for (const PhaseDefinition::Allowance& a : std::vector(phase.allowances))
                        if (a.term == term.name)
                          phase.allowances.push_back({name, a.between_nodes, a.at_nodes});
                      term.name = name;
                      phase.terms.push_back(std::move(term));
                      ++doubled;
                    }
                  }));
  if (doubled == 0) {
    why = "there are no constraints";
    return {};
  }
  return t;
}

Result from_the_solution(const Stated& stated, const Solution& base, Random&, std::string& why) {
  if (!base.ok()) {
    why = "there is no solution to start at";
    return {};
  }
  // The guess is part of the problem. Another guess in the same basin must lead to the same answer.
  return same_answer(stated, guessed_from(stated, base.trajectory, base.durations, {}).problem);
}

}  // namespace

OptimalControlProblem rebuilt(const OptimalControlProblem& problem,
                              const std::function<void(int, PhaseDefinition&)>& edit,
                              const std::function<Jump(int, const Jump&)>& jump) {
  const bool has_maps = problem.closing()
                            ? true
                            : std::any_of(problem.jumps().begin(), problem.jumps().end(),
                                          [](const Jump& j) { return static_cast<bool>(j.map); });
  if (!jump || !has_maps) {
    OptimalControlProblem result = problem;
    for (std::size_t j = 0; j < problem.phases().size(); ++j)
      edit(static_cast<int>(j), result.editable_phase(static_cast<int>(j)));
    return result;
  }
  if (!problem.links().empty()) throw DefinitionError("links and jumps cannot be rebuilt together");
  OptimalControlProblem result(problem.name());
  for (std::size_t j = 0; j < problem.phases().size(); ++j) {
    PhaseDefinition phase = problem.phases()[j];
    edit(static_cast<int>(j), phase);
    const Jump& into = problem.jumps()[j];
    result.then(ErasedPhase(std::move(phase)),
                jump && j > 0 ? jump(static_cast<int>(j), into) : into);
  }
  if (problem.closing()) result.close(jump ? jump(0, *problem.closing()) : *problem.closing());
  result.start_within(problem.start_bounds(), problem.start_guess());
  if (problem.start_time_bounds())
    result.start_time(*problem.start_time_bounds(), problem.start_time());
  else
    result.start_time(problem.start_time());
  result.schedule(problem.schedule()).costs(problem.cost_rule()).total_time(problem.total_time());
  return result;
}

Stated guessed_from(const Stated& stated, const Trajectory& plan,
                    const std::vector<double>& durations, const UnitFactors& units) {
  double begin = plan.start_time();
  return {rebuilt(stated.problem,
                  [&](int j, PhaseDefinition& phase) {
                    const double first = begin, length = durations[j];
                    begin += length;
                    phase.duration_guess = length / units.time;
                    const auto inside = [=](double f) {
                      return first + std::min(f, 1.0 - 1e-9) * length;
                    };
                    const auto factors = [j](const std::vector<VectorXd>& all, int size) {
                      return all.empty() ? VectorXd::Ones(size).eval() : all[j];
                    };
                    const VectorXd x = factors(units.state, phase.sizes.nx);
                    const VectorXd u = factors(units.input, phase.sizes.nu);
                    phase.state_guess = Guess::trajectory(
                        [=](double f) { return plan.state(inside(f)).cwiseQuotient(x).eval(); });
                    if (phase.sizes.nu > 0)
                      phase.input_guess = Guess::trajectory(
                          [=](double f) { return plan.input(inside(f)).cwiseQuotient(u).eval(); });
                  }),
          stated.options};
}

const std::vector<Law>& laws() {
  static const std::vector<Law> all{
      {"start_moved", "start by 1e-12 to 1e-2: the cost changes as the multipliers predict",
       start_moved},
      {"idle_bounds", "bounds of 1e3 to 1e30 magnitudes that are never active", idle_bounds},
      {"ends_softened", "end constraints as L1 penalties of 1e8 to 1e14", ends_softened},
      {"constant_rows", "rows on data, on time and on nothing", constant_rows},
      {"written_twice", "every hard constraint twice", written_twice},
      {"other_units", "units of states, inputs, time and cost by 1e-6 to 1e6", in_other_units},
      {"split_in_two", "a phase split in two", split_in_two},
      {"from_the_solution", "the solution as the guess", from_the_solution},
  };
  return all;
}

}  // namespace saltus::metamorphic
