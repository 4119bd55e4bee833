#include "saltus/transcription/multiple_shooting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/transcription/between_nodes.hpp"
#include "saltus/transcription/crossing_report.hpp"
#include "saltus/transcription/integration_failure.hpp"
#include "saltus/transcription/shooting_program.hpp"
#include "saltus/transcription/shooting_stages.hpp"
#include "saltus/transcription/violation.hpp"

namespace saltus {
namespace {

using namespace shooting;

std::vector<int> base_intervals(const OptimalControlProblem& problem,
                                const ShootingOptions& options) {
  problem.check();
  if (!options.integrator)
    throw DefinitionError(
        fmt::format("problem '{}': the shooting options name no integrator", problem.name()));
  if (options.intervals.empty())
    return std::vector<int>(problem.phases().size(), options.intervals_per_phase);
  if (options.intervals.size() != problem.phases().size())
    throw DefinitionError(
        fmt::format("problem '{}': intervals are given for {} phases, but it has {}",
                    problem.name(), options.intervals.size(), problem.phases().size()));
  return options.intervals;
}

void require_finite(const VectorRef& v, const std::string& what) {
  for (int i = 0; i < v.size(); ++i)
    if (!std::isfinite(v[i]))
      throw DefinitionError(fmt::format("{}: entry {} is {}", what, i, v[i]));
}

}  // namespace

MultipleShooting::MultipleShooting(OptimalControlProblem problem, ShootingOptions options) {
  const std::vector<int> intervals = base_intervals(problem, options);
  program_ = std::make_unique<ShootingProgram>(std::move(problem), intervals, options.integrator);
  integrator_name_ = options.integrator->name();
}

MultipleShooting::~MultipleShooting() = default;
MultipleShooting::MultipleShooting(MultipleShooting&&) noexcept = default;
MultipleShooting& MultipleShooting::operator=(MultipleShooting&&) noexcept = default;

NonlinearProgram& MultipleShooting::nlp() { return *program_; }
const OptimalControlProblem& MultipleShooting::problem() const { return program_->problem(); }
const Grid& MultipleShooting::grid() const { return program_->grid(); }
const Layout& MultipleShooting::layout() const { return program_->layout(); }
StageStructure MultipleShooting::stages() const { return stage_structure(*program_); }

// --- data of the next solve ---------------------------------------------------------------------

void MultipleShooting::start_at(double t, const VectorRef& state) {
  const int nx = problem().phases().front().sizes.nx;
  if (state.size() != nx)
    throw DefinitionError(
        fmt::format("start of problem '{}': it has {} entries, expected {} states",
                    problem().name(), state.size(), nx));
  if (!state.allFinite()) require_finite(state, "start of problem '" + problem().name() + "'");
  start_time(t);
  const bool was_given = program_->is_given_start(0, 0);
  program_->problem().move_start(state);
  program_->start_bounds = problem().start_bounds();
  if (was_given)
    program_->refresh_start();
  else
    program_->refresh();  // constraints on a given state are dropped, which is always possible
}

void MultipleShooting::start_time(double t) {
  if (!std::isfinite(t)) throw DefinitionError("the start time is not finite");
  if (t == program_->start_time) return;
  const double before = std::exchange(program_->start_time, t);
  try {
    replace_grid();
  } catch (const DefinitionError&) {  // bounds of different windows now exclude one another
    program_->start_time = before;
    replace_grid();
    throw;
  }
}

void MultipleShooting::replace_grid() {
  program_->grid().place(problem().schedule(), program_->start_time);
  program_->refresh();
}

void MultipleShooting::set_data(std::string_view parameter, const VectorRef& value) {
  const auto for_each_block = [&](auto&& visit) {
    for (std::size_t j = 0; j < problem().phases().size(); ++j) {
      int first = 0;
      for (const ParameterBlock& block : problem().phases()[j].parameters) {
        if (block.name == parameter) visit(static_cast<int>(j), first, block);
        first += static_cast<int>(block.value.size());
      }
    }
  };
  bool found = false;
  for_each_block([&](int, int, const ParameterBlock& block) {
    found = true;
    if (block.unknown)
      throw DefinitionError(
          fmt::format("parameter '{}' is unknown: the solver decides it", parameter));
    if (value.size() != block.value.size())
      throw DefinitionError(fmt::format("parameter '{}' has {} entries, but {} were given",
                                        parameter, block.value.size(), value.size()));
  });
  if (!found) {
    std::vector<std::string> names;
    for (const PhaseDefinition& phase : problem().phases())
      for (const ParameterBlock& block : phase.parameters)
        if (!block.unknown) names.push_back(block.name);
    const std::string near = nearest_name(parameter, names);
    throw DefinitionError(fmt::format("problem '{}' has no data parameter '{}'{}", problem().name(),
                                      parameter,
                                      near.empty() ? "" : "; did you mean '" + near + "'?"));
  }
  if (!value.allFinite()) require_finite(value, fmt::format("parameter '{}'", parameter));
  for_each_block([&](int j, int first, const ParameterBlock&) {
    for (Eigen::Index i = 0; i < value.size(); ++i)
      program_->set_data(j, first + static_cast<int>(i), value[i]);
  });
}

void MultipleShooting::retime(std::string_view event, double time) {
  Schedule& schedule = program_->problem().editable_schedule();
  const double before = schedule.time_of(event);
  if (time == before) return;
  schedule.retime(event, time);
  try {
    replace_grid();
  } catch (const DefinitionError&) {  // bounds of different windows now exclude one another
    schedule.retime(event, before);
    replace_grid();
    throw;
  }
}

void MultipleShooting::set_schedule(const Schedule& schedule) {
  Grid::check_events(problem(), schedule);
  program_->schedule_before.adopt(problem().schedule());
  program_->problem().editable_schedule().adopt(schedule);
  try {
    replace_grid();
  } catch (const DefinitionError&) {  // bounds of different windows now exclude one another
    program_->problem().editable_schedule().adopt(program_->schedule_before);
    replace_grid();
    throw;
  }
}

void MultipleShooting::set_previous_input(const VectorRef& input) {
  const int nu = problem().phases().front().sizes.nu;
  if (input.size() != nu)
    throw DefinitionError(fmt::format("the previous input has {} entries, but phase '{}' has {}",
                                      input.size(), problem().phases().front().name, nu));
  for (int i = 0; i < nu; ++i)
    if (std::isinf(input[i]))
      throw DefinitionError(fmt::format("previous input: entry {} is infinite", i));
  program_->previous_input = input;
  program_->refresh_changes();
}

void MultipleShooting::set_penalty_weight(std::string_view weight_name, double weight) {
  if (!(weight > 0.0 && std::isfinite(weight)))
    throw DefinitionError(
        fmt::format("penalty weight '{}' is {}, expected a positive number", weight_name, weight));
  if (!program_->problem().set_penalty_weight(weight_name, weight))
    throw DefinitionError(
        fmt::format("problem '{}' has no penalty weight '{}'", problem().name(), weight_name));
  program_->refresh_rows();
}

// --- guesses ------------------------------------------------------------------------------------

NlpPoint MultipleShooting::initial_guess() const {
  NlpPoint point{VectorXd::Zero(program_->variables()), {}, {}};
  VectorXd& w = point.w;
  VectorXd start = problem().start_guess();
  for (int j = 0; j < grid().phases(); ++j) {
    const PhaseDefinition& phase = problem().phases()[j];
    const int nx = phase.sizes.nx, nu = phase.sizes.nu;
    const double T = grid().reference_duration(j);
    const VectorXd p = program_->parameters_of(j, nullptr);
    for (int i = 0; i < p.size(); ++i)
      if (layout().parameter(j, i) >= 0)
        w[layout().parameter(j, i)] = p[i] / phase.nominal_parameter(i);
    if (layout().duration(j) >= 0) w[layout().duration(j)] = T / phase.nominal_duration;

    const auto fraction = [&](int node) { return T > 0.0 ? grid().node_offset(j, node) / T : 0.0; };
    const auto input = [&](int k, double at) {
      VectorXd u = phase.input_guess.is_given() ? phase.input_guess.at(at) : VectorXd::Zero(nu);
      for (int i = 0; i < nu; ++i) {
        const Bounds b = program_->input_bounds(j, k, i);
        u[i] = std::clamp(u[i], b.lower, b.upper);
      }
      return u;
    };
    const auto set_state = [&](int node, const VectorXd& x) {
      w.segment(layout().state(j, node), nx) = x.cwiseQuotient(phase.nominal_state);
    };

    VectorXd x = phase.state_guess.is_given() ? phase.state_guess.at(0.0) : start;
    Integrator& integrator = *program_->integrators()[j];
    const IntervalArguments a = integrator.arguments();
    VectorXd argument(a.size()), end(integrator.outputs());
    set_state(0, x);
    for (int k = 0; k < grid().intervals(j); ++k) {
      VectorXd c(a.nc);
      c.head(nu) = input(k, fraction(k));
      if (phase.input_shape() == InputShape::linear) c.tail(nu) = input(k, fraction(k + 1));
      for (int i = 0; i < a.nc; ++i)
        w[layout().input(j, k) + i] = c[i] / phase.nominal_input[i % nu];
      if (phase.state_guess.is_simulated()) {
        argument << x, c, p, program_->start_of(j, nullptr) + grid().node_offset(j, k),
            grid().node_offset(j, k + 1) - grid().node_offset(j, k);
        if (integrator.value(argument.data(), end.data()) == IntegrationStatus::success)
          x = end.head(nx);
      } else if (phase.state_guess.is_given()) {
        x = phase.state_guess.at(fraction(k + 1));
      }
      set_state(k + 1, x);
    }
    if (j + 1 == grid().phases()) break;
    start = problem().jumps()[j + 1].apply(program_->start_of(j + 1, nullptr), x, p);
  }
  return point;
}

NlpPoint MultipleShooting::guess_from(const Trajectory& trajectory) const {
  NlpPoint point = initial_guess();
  if (trajectory.empty()) return point;
  double start = program_->start_time;
  for (int j = 0; j < grid().phases(); ++j) {
    const PhaseDefinition& phase = problem().phases()[j];
    const int nx = phase.sizes.nx, nu = phase.sizes.nu;
    double T = grid().reference_duration(j);
    if (layout().duration(j) >= 0) {  // it ends when it ended there
      for (const TrajectoryPiece& piece : trajectory.pieces())
        if (piece.phase == j)
          T = std::clamp(piece.end() - start, phase.duration.lower, phase.duration.upper);
      point.w[layout().duration(j)] = T / phase.nominal_duration;
    }
    if (j < static_cast<int>(trajectory.phases().size()) &&
        trajectory.phases()[j].parameters.size() == phase.sizes.np)
      for (int i = 0; i < phase.sizes.np; ++i)
        if (layout().parameter(j, i) >= 0)
          point.w[layout().parameter(j, i)] =
              trajectory.phases()[j].parameters[i] / phase.nominal_parameter(i);
    const auto time_of = [&](int node) {
      return node == grid().intervals(j) ? start + T : start + grid().interval(j, node).offset(T);
    };
    for (int k = 0; k <= grid().intervals(j); ++k) {
      const double t = time_of(k);
      const bool closes = k == grid().intervals(j);  // with x-, before any jump
      const VectorXd x = closes ? trajectory.state_before(t) : trajectory.state(t);
      if (x.size() != nx) continue;  // another phase is in force there
      point.w.segment(layout().state(j, k), nx) = x.cwiseQuotient(phase.nominal_state);
      if (closes || grid().interval(j, k).is_empty()) continue;
      // From the middle of the interval: the ends may belong to neighbours.
      const double next = time_of(k + 1);
      const auto set_input = [&](int first, double at) {
        const VectorXd u = trajectory.input(at);
        if (u.size() != nu) return;
        for (int i = 0; i < nu; ++i) {
          const Bounds b = program_->input_bounds(j, k, i);
          point.w[layout().input(j, k) + first + i] =
              std::clamp(u[i], b.lower, b.upper) / phase.nominal_input[i];
        }
      };
      const bool linear = phase.input_shape() == InputShape::linear;
      constexpr double just_inside = 1e-9;  // of the interval
      set_input(0, linear ? t + just_inside * (next - t) : 0.5 * (t + next));
      if (linear) set_input(nu, next - just_inside * (next - t));
    }
    start += T;
  }
  // A start that is given, or bounded, is not the trajectory's to decide.
  const PhaseDefinition& first = problem().phases().front();
  for (int i = 0; i < first.sizes.nx; ++i) {
    double& x = point.w[layout().state(0, 0) + i];
    const Bounds& b = program_->start_bounds[i];
    x = std::clamp(x, b.lower / first.nominal_state[i], b.upper / first.nominal_state[i]);
  }
  return point;
}

// --- solutions ----------------------------------------------------------------------------------

Trajectory MultipleShooting::trajectory(const VectorXd& w) const {
  std::vector<Trajectory::PhaseInfo> phases;
  std::vector<TrajectoryPiece> pieces;
  for (int j = 0; j < grid().phases(); ++j) {
    const PhaseDefinition& phase = problem().phases()[j];
    phases.push_back({phase.name, program_->parameters_of(j, &w), program_->integrators()[j]});
    const double T = program_->duration_of(j, &w);
    const double start = program_->start_of(j, &w);
    const auto state = [&](int node) -> VectorXd {
      return w.segment(layout().state(j, node), phase.sizes.nx).cwiseProduct(phase.nominal_state);
    };
    for (int k = 0; k < grid().intervals(j); ++k) {
      const GridInterval& interval = grid().interval(j, k);
      if (interval.is_empty()) continue;
      TrajectoryPiece piece{
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

// Sums the outputs of cost blocks per term, in the order of phases and terms.
std::vector<CostContribution> cost_contributions(ShootingProgram& program, const VectorXd& w) {
  std::vector<CostContribution> contributions;
  std::vector<std::vector<int>> index;
  for (const PhaseDefinition& phase : program.problem().phases()) {
    auto& of_phase = index.emplace_back(phase.terms.size() + 1, -1);
    for (std::size_t t = 0; t < phase.terms.size(); ++t) {
      const Term& term = phase.terms[t];
      if (term.kind == TermKind::constraint && !term.soft) continue;
      of_phase[t] = static_cast<int>(contributions.size());
      contributions.push_back({phase.name, term.name, 0.0});
    }
    if (phase.input_change_weight.size() == 0) continue;
    of_phase.back() = static_cast<int>(contributions.size());
    contributions.push_back({phase.name, "change of inputs", 0.0});
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
    for (const auto* slacks : {&instance.slack_below, &instance.slack_above})
      for (const int s : *slacks)
        if (s >= 0)
          contributions[index[instance.phase][instance.term]].value += program.slack_cost(s, w);
  }
  return contributions;
}

std::vector<SoftViolation> soft_violations(const ShootingProgram& program, const VectorXd& w) {
  std::vector<SoftViolation> uses;
  for (const RowInstance& instance : program.row_instances()) {
    const PhaseDefinition& phase = program.problem().phases()[instance.phase];
    const Term& term = phase.terms[instance.term];
    if (!term.soft) continue;
    auto use = std::find_if(uses.begin(), uses.end(), [&](const SoftViolation& u) {
      return u.phase == phase.name && u.term == term.name;
    });
    if (use == uses.end()) use = uses.insert(use, SoftViolation{phase.name, term.name, 0.0, 0.0});
    for (const auto* slacks : {&instance.slack_below, &instance.slack_above})
      for (const int s : *slacks)
        if (s >= 0 && w[s] > use->largest) {
          use->largest = w[s];
          use->time = program.time_of(instance.block.point, &w);
        }
  }
  return uses;
}

}  // namespace

Solution MultipleShooting::interpret(NlpResult result) {
  Solution solution;
  solution.status = result.status;
  solution.message = describe(result.status);
  if (!solution.ok() && result.point.w.size() == program_->variables()) {
    const std::string violation = name_violation(*program_, result.point.w);
    if (!violation.empty()) solution.message += "; " + violation;
    if (result.status == SolveStatus::evaluation_failed) {
      const std::string failure = name_integration_failure(*program_, result.point.w);
      if (!failure.empty()) solution.message += "; " + failure;
    }
  }
  solution.cost = result.objective;
  solution.kkt = result.kkt;
  solution.iterations = result.iterations;
  solution.seconds = result.seconds;
  solution.method = fmt::format(
      "{}, {}, {} Hessian", integrator_name_,
      problem().cost_rule() == CostRule::nodes ? "costs summed at the nodes" : "costs integrated",
      result.hessian);
  const VectorXd& w = result.point.w;
  if (w.size() == program_->variables()) {
    solution.trajectory = trajectory(w);
    solution.costs = cost_contributions(*program_, w);
    solution.soft_violations = soft_violations(*program_, w);
    for (int j = 0; j < grid().phases(); ++j)
      solution.durations.push_back(program_->duration_of(j, &w));
    solution.crossings = guard_crossings(problem(), solution.trajectory);
    const std::string doubt = describe_doubtful(solution.crossings);
    if (solution.ok() && !doubt.empty()) solution.message += "; " + doubt;
  }
  const PhaseDefinition& first = problem().phases().front();
  if (result.point.lambda.size() == program_->rows())
    // L = f + lambda (x_0 - start) / nominal, so d cost / d start = -lambda / nominal.
    solution.start_multipliers = -result.point.lambda.segment(program_->start_row(), first.sizes.nx)
                                      .cwiseQuotient(first.nominal_state);
  solution.point = std::move(result.point);
  return solution;
}

Solution solve(MultipleShooting& shooting, Solver& solver) {
  return solve(shooting, solver, shooting.initial_guess());
}

Solution solve(MultipleShooting& shooting, Solver& solver, const NlpPoint& start) {
  const bool warm = start.lambda.size() == shooting.nlp().rows();
  Solution solution = shooting.interpret(solver.solve(shooting.nlp(), start, warm));
  if (!solution.trajectory.empty()) {
    const auto violations = violations_between_nodes(shooting, solution.trajectory);
    solution.between_nodes = violations.empty() ? PathViolation{} : violations.front();
  }
  return solution;
}

}  // namespace saltus
