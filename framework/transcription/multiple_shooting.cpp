#include "saltus/transcription/multiple_shooting.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/transcription/between_nodes.hpp"
#include "saltus/transcription/shooting_program.hpp"
#include "saltus/transcription/shooting_stages.hpp"

namespace saltus {
namespace {

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

void MultipleShooting::set_entries(std::string_view name, const VectorRef& values,
                                   std::span<const ParameterEntry> entries) {
  check_data(problem(), name, static_cast<int>(values.size()), entries);
  if (!values.allFinite()) require_finite(values, fmt::format("parameter '{}'", name));
  for (std::size_t j = 0; j < problem().phases().size(); ++j)
    if (const auto range = find_parameter(problem().phases()[j], name))
      for (int i = 0; i < range->size; ++i)
        program_->set_data(static_cast<int>(j), range->first + i, values[i]);
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
