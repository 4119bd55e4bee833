#include "problems/library/run_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/replay.hpp"

namespace saltus {
namespace {

// A solve that does not end must not block the next ones.
constexpr double time_limit = 120.0;  // s
// If the flow amplifies errors by more, a replay from the start would measure rounding.
constexpr double steady_growth = 1e4;

CaseOutcome outcome_for(const auto& c) {
  CaseOutcome outcome;
  outcome.id = c.id;
  outcome.name = c.name;
  outcome.exercises = c.exercises;
  outcome.source = c.source;
  return outcome;
}

void check_switching_times(const ReferenceCase& c, const Solution& solution,
                           std::vector<CheckedValue>& checked) {
  double t = solution.trajectory.start_time();
  for (std::size_t j = 0; j < c.switching_times.size(); ++j) {
    t += j < solution.durations.size() ? solution.durations[j] : std::nan("");
    checked.push_back({.name = fmt::format("switching time {}", j + 1),
                       .value = t,
                       .reference = c.switching_times[j],
                       .tolerance = c.switching_tolerance});
  }
}

// The program does not contain path constraints inside the intervals.
void check_between_nodes(const ReferenceCase& c, const Solution& solution, CaseOutcome& outcome) {
  if (!solution.verification) return;
  const Verification::Miss& worst = solution.verification->between_nodes;
  outcome.between_nodes = worst.amount;
  const std::string where = worst.amount > 0.0
                                ? fmt::format(", phase '{}', term '{}' at t = {:.4g} s",
                                              worst.phase, worst.term, worst.time)
                                : "";
  outcome.checked.push_back(
      residual_of("violation between the nodes" + where, worst.amount, c.between_nodes));
}

// A replay must reproduce the plan.
void check_replay(const ReferenceCase& c, const Solution& solution,
                  std::vector<CheckedValue>& checked) {
  const ReplayReport report = replay(c.problem(), solution.trajectory,
                                     cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14}));
  const auto figure = [&](double value) { return report.completed ? value : std::nan(""); };
  checked.push_back(residual_of("replay per interval", figure(report.from_nodes), c.replay));
  if (!c.replay_from_start) return;
  checked.push_back(residual_of("growth of the flow", figure(report.flow_growth), steady_growth));
  checked.push_back(residual_of("replay from the start", figure(report.from_start), c.replay));
}

}  // namespace

std::unique_ptr<Solver> make_case_solver(SolverChoice choice, int max_iterations) {
  return make_solver(choice, {.tolerance = library_solver_tolerance,
                              .max_iterations = max_iterations,
                              .time_limit = time_limit});
}

Solution solve_case(const ReferenceCase& c, SolverChoice choice, const SolveObserver& observer) {
  MultipleShooting shooting(c.problem(), c.options);
  const std::unique_ptr<Solver> solver = make_case_solver(choice, c.max_iterations);
  solver->set_observer(observer);
  return solve(shooting, *solver);
}

CaseOutcome check_case(const ReferenceCase& c, const Solution& solution) {
  CaseOutcome outcome = outcome_for(c);
  outcome.status = solution.message;
  outcome.iterations = solution.iterations;
  outcome.seconds = solution.seconds;
  std::vector<CheckedValue>& checked = outcome.checked;
  checked.push_back({.name = "cost",
                     .value = solution.cost,
                     .reference = c.optimum,
                     .tolerance = c.tolerance * (1.0 + std::abs(c.optimum)),
                     .digits = c.digits});
  if (!solution.ok()) return outcome;  // did not converge
  check_switching_times(c, solution, checked);
  if (c.more)
    for (CheckedValue& v : c.more(solution)) checked.push_back(std::move(v));
  checked.push_back(residual_of("KKT residual", solution.kkt.scaled(), library_kkt_limit));
  check_between_nodes(c, solution, outcome);
  check_replay(c, solution, checked);
  outcome.verdict = judge(checked);
  return outcome;
}

RefinedSolution solve_case_refined(const ReferenceCase& c, SolverChoice choice, int rounds,
                                   const SolveObserver& observer) {
  const std::unique_ptr<Solver> solver = make_case_solver(choice, c.max_iterations);
  solver->set_observer(observer);
  return solve_refined(c.problem(), c.options, *solver,
                       {.tolerance = c.between_nodes, .integration = infinity, .rounds = rounds});
}

CaseOutcome check_case(const ReferenceCase& c, const RefinedSolution& refined) {
  CaseOutcome outcome = check_case(c, refined.solution);
  outcome.iterations = refined.iterations;
  outcome.seconds = refined.seconds;
  outcome.refinements = std::max(1, static_cast<int>(refined.violations.size())) - 1;
  return outcome;
}

CaseOutcome run_case(const ReferenceCase& c, SolverChoice choice, const SolveObserver& observer) {
  try {
    return check_case(c, solve_case_refined(c, choice, RefinementOptions{}.rounds, observer));
  } catch (const DefinitionError& error) {
    CaseOutcome outcome = outcome_for(c);
    outcome.status = error.what();
    if (choice == SolverChoice::riccati) outcome.verdict = Verdict::not_applicable;
    return outcome;
  }
}

CaseOutcome run_case(const SimulationCase& c) {
  CaseOutcome outcome = outcome_for(c);
  outcome.is_simulation = true;
  const auto start = WallClock::now();
  outcome.checked = c.run();
  outcome.seconds = seconds_since(start);
  outcome.verdict = judge(outcome.checked);
  outcome.status = "simulated";
  bring_worst_to_front(outcome.checked);
  return outcome;
}

}  // namespace saltus
