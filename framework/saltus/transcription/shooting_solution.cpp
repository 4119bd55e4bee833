// Converts a point of the program into a solution of the problem: trajectory, costs, messages.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/transcription/crossing_report.hpp"
#include "saltus/transcription/dependent_rows.hpp"
#include "saltus/transcription/integration_failure.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/shooting_program.hpp"
#include "saltus/transcription/violation.hpp"

namespace saltus {

using namespace shooting;

Trajectory MultipleShooting::trajectory(const VectorXd& w) const {
  if (w.size() != checked().variables())
    throw DefinitionError(fmt::format("trajectory: a point of {} variables is given, expected {}",
                                      w.size(), program_->variables()));
  std::vector<Trajectory::PhaseInfo> phases;
  std::vector<Trajectory::Piece> pieces;
  for (int j = 0; j < grid().phases(); ++j) {
    const PhaseDefinition& phase = problem().phases()[j];
    phases.push_back(
        {phase.name, program_->parameters_of(j, &w), program_->reentrant_integrators()[j]});
    const double T = program_->duration_of(j, &w);
    const double start = program_->start_of(j, &w);
    const auto state = [&](int node) -> VectorXd {
      return w.segment(layout().state(j, node), phase.sizes.nx).cwiseProduct(phase.nominal_state);
    };
    for (int k = 0; k < grid().intervals(j); ++k) {
      const Grid::Interval& interval = grid().interval(j, k);
      if (interval.is_empty()) continue;
      Trajectory::Piece piece{
          j, start + interval.offset(T), interval.length(T), state(k), {}, state(k + 1)};
      piece.coefficients.resize(program_->integrators()[j]->arguments().nc);
      for (int i = 0; i < piece.coefficients.size(); ++i)
        piece.coefficients[i] =
            w[layout().input(j, k) + i] * phase.nominal_input[i % phase.sizes.nu];
      pieces.push_back(std::move(piece));
    }
  }
  return {std::move(phases), std::move(pieces)};
}

namespace {

const std::string& name_of(const ShootingProgram& program, const LimitInstance& instance) {
  const OptimalControlProblem& problem = program.problem();
  return instance.link >= 0 ? problem.links()[instance.link].name
                            : problem.phases()[instance.phase].integrals[instance.integral].name;
}

// Sums the outputs of cost blocks per term, in the order of phases and terms.
std::vector<Solution::CostContribution> cost_contributions(ShootingProgram& program,
                                                           const VectorXd& w) {
  std::vector<Solution::CostContribution> contributions;
  std::vector<std::vector<int>> index;
  for (const PhaseDefinition& phase : program.problem().phases()) {
    auto& of_phase = index.emplace_back(phase.terms.size() + 1, -1);
    for (std::size_t t = 0; t < phase.terms.size(); ++t) {
      const Term& term = phase.terms[t];
      if (term.kind == Term::Kind::constraint && !term.soft) continue;
      of_phase[t] = static_cast<int>(contributions.size());
      contributions.push_back({phase.name, term.name, 0.0});
    }
    if (phase.input_change_weight.size() == 0) continue;
    of_phase.back() = static_cast<int>(contributions.size());
    contributions.push_back({phase.name, change_of_inputs, 0.0});
  }
  VectorXd outputs;
  const auto add = [&](int block, int output, double& total) {
    outputs.resize(program.block_outputs(block));
    program.evaluate_block(block, w.data(), outputs.data());
    const double weight = program.weight(block, output);
    if (weight != 0.0) total += weight * outputs[output];
  };
  for (const CostInstance& instance : program.cost_instances())
    add(instance.block, instance.output, contributions[index[instance.phase][instance.term]].value);
  for (const ChangeInstance& instance : program.change_instances())
    for (int i = 0; i < program.problem().phases()[instance.phase].sizes.nu; ++i)
      add(instance.block, i, contributions[index[instance.phase].back()].value);
  for (const RowInstance& instance : program.row_instances()) {
    if (!program.problem().phases()[instance.phase].terms[instance.term].soft) continue;
    for (const auto* slacks : {&instance.slack_below, &instance.slack_above, &instance.slack_free})
      for (const int s : *slacks)
        if (s >= 0)
          contributions[index[instance.phase][instance.term]].value += program.slack_cost(s, w);
  }
  for (const LinkCost& cost : program.link_costs()) {
    contributions.push_back({program.problem().phases()[cost.phase].name,
                             program.problem().links()[cost.link].name, 0.0});
    add(cost.block, 0, contributions.back().value);
  }
  for (const LimitInstance& instance : program.limit_instances()) {
    if (!program.limits_of(instance).soft) continue;
    double paid = 0.0;
    for (const auto* slacks : {&instance.slack_below, &instance.slack_above, &instance.slack_free})
      for (const int s : *slacks)
        if (s >= 0) paid += program.slack_cost(s, w);
    contributions.push_back(
        {program.problem().phases()[instance.phase].name, name_of(program, instance), paid});
  }
  return contributions;
}

std::vector<Solution::SoftViolation> soft_violations(const ShootingProgram& program,
                                                     const VectorXd& w) {
  std::vector<Solution::SoftViolation> uses;
  const auto note = [&](Solution::SoftViolation& use, const auto& instance,
                        const GridPoint& point) {
    for (std::size_t i = 0; i < instance.slack_below.size(); ++i) {
      const int below = instance.slack_below[i], above = instance.slack_above[i],
                both = instance.slack_free[i];
      const double part = both >= 0 ? w[both] : 0.0;  // part of the violation; > 0: below
      const double violation =
          std::max(below >= 0 ? w[below] + part : 0.0, above >= 0 ? w[above] - part : 0.0);
      if (violation > use.largest) {
        use.largest = violation;
        use.time = program.time_of(point, &w);
      }
    }
  };
  for (const RowInstance& instance : program.row_instances()) {
    const PhaseDefinition& phase = program.problem().phases()[instance.phase];
    const Term& term = phase.terms[instance.term];
    if (!term.soft) continue;
    auto use = std::find_if(uses.begin(), uses.end(), [&](const Solution::SoftViolation& u) {
      return u.phase == phase.name && u.term == term.name;
    });
    if (use == uses.end())
      use = uses.insert(use, Solution::SoftViolation{phase.name, term.name, 0.0, 0.0});
    note(*use, instance, instance.block.point);
  }
  for (const LimitInstance& instance : program.limit_instances())
    if (program.limits_of(instance).soft) {
      uses.push_back(
          {program.problem().phases()[instance.phase].name, name_of(program, instance), 0.0, 0.0});
      note(uses.back(), instance, instance.point);
    }
  return uses;
}

// Name of the first term without a finite value at w, constraints before costs. Empty if there is
// none.
std::string describe_nonfinite_term(ShootingProgram& program, const VectorXd& w) {
  VectorXd outputs;
  const auto is_finite = [&](int block) {
    outputs.resize(program.block_outputs(block));
    program.evaluate_block(block, w.data(), outputs.data());
    return outputs.allFinite();
  };
  for (const RowInstance& instance : program.row_instances())
    if (!is_finite(instance.block.block))
      return program.describe_row(instance.first_row, &w) + " has no finite value";
  for (const CostInstance& instance : program.cost_instances()) {
    if (is_finite(instance.block)) continue;
    const PhaseDefinition& phase = program.problem().phases()[instance.phase];
    return fmt::format(
        "phase '{}', term '{}'{} has no finite value", phase.name, phase.terms[instance.term].name,
        instance.interval < 0 ? "" : fmt::format(" in interval {}", instance.interval));
  }
  return {};
}

// One clause about free phases whose duration is zero to the solver's tolerance. Empty if there are
// none.
std::string describe_zero_durations(const OptimalControlProblem& problem,
                                    const std::vector<double>& durations) {
  constexpr double negligible = 1e-6;  // relative to the guess
  std::string names;
  for (std::size_t j = 0; j < durations.size(); ++j) {
    const PhaseDefinition& phase = problem.phases()[j];
    if (phase.has_free_duration() && durations[j] <= negligible * phase.duration_guess)
      names += fmt::format("{}phase '{}'", names.empty() ? "" : ", ", phase.name);
  }
  return names.empty() ? names : "without effect, because their duration is zero: " + names;
}

// Describes the Hessian approximation and which second derivatives are missing.
std::string describe_hessian(const ShootingProgram& program, const std::string& hessian) {
  std::string names;
  for (std::size_t j = 0; j < program.integrators().size(); ++j)
    if (!program.integrators()[j]->has_hessian())
      names += fmt::format("{}phase '{}'", names.empty() ? "" : ", ",
                           program.problem().phases()[j].name);
  if (!names.empty()) names = ", because the integration has no second derivatives in " + names;
  return fmt::format("; {} Hessian{}", hessian, names);
}

const char* describe_costs(const OptimalControlProblem& problem) {
  int integrated = 0;
  const int phases = static_cast<int>(problem.phases().size());
  for (int j = 0; j < phases; ++j)
    integrated += problem.cost_rule(j) == CostRule::integrated ? 1 : 0;
  return integrated == phases ? "costs integrated"
         : integrated == 0    ? "costs summed at the nodes"
                              : "costs summed at the nodes, integrated where inputs are linear";
}

}  // namespace

Solution::Solution() = default;
Solution::Solution(const Solution& other) = default;
Solution::Solution(Solution&& other) noexcept = default;
Solution& Solution::operator=(const Solution& other) = default;
Solution& Solution::operator=(Solution&& other) noexcept = default;
Solution::~Solution() = default;

Solution MultipleShooting::interpret(NlpResult result, int inside) {
  checked();
  Solution solution;
  solution.status = result.status;
  const bool is_proved = result.contradiction || result.is_proved_infeasible;
  solution.message =
      is_proved ? "the constraints cannot all be satisfied" : describe(result.status);
  if (!solution.ok() && result.point.w.size() == program_->variables()) {
    std::string reason;
    if (result.status == SolveStatus::invalid_problem)
      reason = describe_dependent_rows(*program_, result.point.w);
    if (result.contradiction)
      reason = describe_contradiction(*program_, *result.contradiction, result.point.w);
    if (reason.empty()) reason = describe_violation(*program_, result.point.w);
    if (!reason.empty()) solution.message += "; " + reason;
    if (result.status == SolveStatus::infeasible && !result.contradiction) {
      const std::string conflict = describe_conflict(*program_, result.point.lambda, reason);
      if (!conflict.empty()) solution.message += "; " + conflict;
    }
    if (result.status == SolveStatus::infeasible || result.status == SolveStatus::iteration_limit ||
        result.status == SolveStatus::numerical_failure)
      if (const std::string phase = first_phase_with_events(problem()); !phase.empty())
        solution.message += "; " + events_hint(phase);
    if (result.status == SolveStatus::evaluation_failed) {
      std::string failure = describe_integration_failure(*program_, result.point.w);
      if (failure.empty()) failure = describe_nonfinite_term(*program_, result.point.w);
      if (!failure.empty()) solution.message += "; " + failure;
    }
  }
  if (!result.contradiction && !result.hessian.empty() && result.hessian != "exact" &&
      result.point.w.size() == program_->variables())
    solution.message += describe_hessian(*program_, result.hessian);
  solution.cost = result.objective;
  solution.kkt = result.kkt;
  solution.iterations = result.iterations;
  solution.seconds = result.seconds;
  solution.method = fmt::format("{}, {}, {} Hessian", options_.integrator->name(),
                                describe_costs(problem()), result.hessian);
  const VectorXd& w = result.point.w;
  if (w.size() == program_->variables()) {
    solution.trajectory = trajectory(w);
    solution.costs = cost_contributions(*program_, w);
    solution.soft_violations = soft_violations(*program_, w);
    for (int j = 0; j < grid().phases(); ++j) {
      solution.durations.push_back(program_->duration_of(j, &w));
      const PhaseDefinition& phase = problem().phases()[j];
      const int last = layout().integral(j, grid().intervals(j));
      for (std::size_t i = 0; i < phase.integrals.size(); ++i)
        solution.integrals.push_back(
            {phase.name, phase.integrals[i].name,
             w[last + static_cast<int>(i)] * phase.integrals[i].magnitude});
    }
    solution.crossings = guard_crossings(problem(), solution.trajectory, inside);
    const auto doubtful =
        std::ranges::find_if_not(solution.crossings, &Solution::GuardCrossing::is_as_declared);
    if (solution.ok() && doubtful != solution.crossings.end())
      solution.message += "; " + describe_crossing_error(*doubtful);
    const std::string vanished = describe_zero_durations(problem(), solution.durations);
    if (solution.ok() && !vanished.empty()) solution.message += "; " + vanished;
  }
  const PhaseDefinition& first = problem().phases().front();
  if (result.point.lambda.size() == program_->rows())
    // L = f + lambda (x_0 - start) / nominal, so d cost / d start = -lambda / nominal.
    solution.start_multipliers = -result.point.lambda.segment(program_->start_row(), first.sizes.nx)
                                      .cwiseQuotient(first.nominal_state);
  solution.point = std::move(result.point);
  return solution;
}

}  // namespace saltus
