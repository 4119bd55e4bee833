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

}  // namespace

MultipleShooting::MultipleShooting(OptimalControlProblem problem, ShootingOptions options) {
  const std::vector<int> intervals = base_intervals(problem, options);
  program_ = std::make_unique<ShootingProgram>(std::move(problem), intervals, options.integrator);
  next_ = program_->data();
  integrator_name_ = options.integrator->name();
}

MultipleShooting::~MultipleShooting() = default;
MultipleShooting::MultipleShooting(MultipleShooting&&) noexcept = default;
MultipleShooting& MultipleShooting::operator=(MultipleShooting&&) noexcept = default;

NonlinearProgram& MultipleShooting::nlp() { return *program_; }
const OptimalControlProblem& MultipleShooting::problem() const { return program_->problem(); }
const Grid& MultipleShooting::grid() const { return program_->grid(); }
const ProblemData& MultipleShooting::data() const { return program_->data(); }
const Layout& MultipleShooting::layout() const { return program_->layout(); }
StageStructure MultipleShooting::stages() const { return stage_structure(*program_); }

// --- data of the next solve ---------------------------------------------------------------------

template <class Edit>
void MultipleShooting::change(Edit&& edit) {
  next_ = program_->data();
  edit(next_);
  program_->commit(next_);
}

void MultipleShooting::start_at(double t, const VectorRef& state) {
  const int nx = problem().phases().front().sizes.nx;
  if (state.size() != nx)
    throw DefinitionError(
        fmt::format("start of problem '{}': it has {} entries, expected {} states",
                    problem().name(), state.size(), nx));
  change([&](ProblemData& next) {
    next.start_time = t;
    for (int i = 0; i < nx; ++i) next.start_bounds[i] = exactly(state[i]);
  });
}

void MultipleShooting::start_time(double t) {
  change([&](ProblemData& next) { next.start_time = t; });
}

void MultipleShooting::set_entries(std::string_view name, const VectorRef& values,
                                   std::span<const ParameterEntry> entries) {
  check_data(problem(), name, static_cast<int>(values.size()), entries);
  for (int i = 0; i < values.size(); ++i)  // by the name that was given
    if (!std::isfinite(values[i]))
      throw DefinitionError(fmt::format("parameter '{}': entry {} is {}", name, i, values[i]));
  change([&](ProblemData& next) {
    for (std::size_t j = 0; j < problem().phases().size(); ++j)
      if (const auto range = find_parameter(problem().phases()[j], name))
        next.parameters[j].segment(range->first, range->size) = values;
  });
}

void MultipleShooting::retime(std::string_view event, double time) {
  change([&](ProblemData& next) { next.schedule.retime(event, time); });
}

void MultipleShooting::set_schedule(const Schedule& schedule) {
  change([&](ProblemData& next) { next.schedule.adopt(schedule); });
}

void MultipleShooting::set_previous_input(const VectorRef& input) {
  const PhaseDefinition& first = problem().phases().front();
  if (input.size() != first.sizes.nu)
    throw DefinitionError(fmt::format("the previous input has {} entries, but phase '{}' has {}",
                                      input.size(), first.name, first.sizes.nu));
  change([&](ProblemData& next) { next.previous_input = input; });
}

void MultipleShooting::set_penalty_weight(std::string_view weight_name, double weight) {
  if (!(weight > 0.0 && std::isfinite(weight)))
    throw DefinitionError(
        fmt::format("penalty weight '{}' is {}, expected a positive number", weight_name, weight));
  if (!program_->set_penalty_weight(weight_name, weight))
    throw DefinitionError(
        fmt::format("problem '{}' has no penalty weight '{}'", problem().name(), weight_name));
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
