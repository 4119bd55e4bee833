#include "saltus/transcription/multiple_shooting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <string>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/ocp/windows_of.hpp"
#include "saltus/transcription/crossing_report.hpp"
#include "saltus/transcription/exact_penalties.hpp"
#include "saltus/transcription/multipliers.hpp"
#include "saltus/transcription/shooting_program.hpp"
#include "saltus/transcription/shooting_stages.hpp"
#include "saltus/transcription/verdict.hpp"

namespace saltus {
namespace {

std::vector<Mesh> meshes_of(const OptimalControlProblem& problem, const ShootingOptions& options) {
  problem.check();
  if (!options.integrator)
    throw DefinitionError(
        fmt::format("problem '{}': the shooting options have no integrator", problem.name()));
  const std::size_t phases = problem.phases().size();
  const auto expect_one_per_phase = [&](const char* what, std::size_t given) {
    if (given != 0 && given != phases)
      throw DefinitionError(fmt::format("problem '{}': {} are given for {} phases, but it has {}",
                                        problem.name(), what, given, phases));
  };
  expect_one_per_phase("meshes", options.meshes.size());
  expect_one_per_phase("intervals", options.intervals.size());
  if (!options.meshes.empty()) return options.meshes;
  std::vector<Mesh> meshes(phases, Mesh{.intervals = options.intervals_per_phase});
  for (std::size_t j = 0; j < options.intervals.size(); ++j)
    meshes[j].intervals = options.intervals[j];
  return meshes;
}

}  // namespace

MultipleShooting::MultipleShooting(OptimalControlProblem problem, ShootingOptions options) {
  options.meshes = meshes_of(problem, options);
  const auto largest = std::ranges::max_element(options.meshes, {}, &Mesh::intervals);
  const std::string of = fmt::format("{} intervals of phase '{}'", largest->intervals,
                                     problem.phases()[largest - options.meshes.begin()].name);
  try {
    program_ = std::make_unique<ShootingProgram>(std::move(problem), options.meshes,
                                                 options.integrator, options.threads);
    next_ = program_->data();
  } catch (const std::bad_alloc&) {
    throw DefinitionError("there is not enough memory for " + of + ": use fewer intervals");
  }
  options_ = std::move(options);
}

MultipleShooting::~MultipleShooting() = default;
MultipleShooting::MultipleShooting(MultipleShooting&&) noexcept = default;
MultipleShooting& MultipleShooting::operator=(MultipleShooting&&) noexcept = default;

ShootingProgram& MultipleShooting::checked() const {
  if (!program_) throw DefinitionError("multiple shooting: it has been moved from");
  return *program_;
}

NonlinearProgram& MultipleShooting::nlp() { return checked(); }
const OptimalControlProblem& MultipleShooting::problem() const { return checked().problem(); }
const Grid& MultipleShooting::grid() const { return checked().grid(); }
const ProblemData& MultipleShooting::data() const { return checked().data(); }
const Layout& MultipleShooting::layout() const { return checked().layout(); }
qp::StageStructure MultipleShooting::stages() const { return stage_structure(checked()); }

// --- data of the next solve ---------------------------------------------------------------------

template <class Edit>
void MultipleShooting::change(Edit&& edit) {
  next_ = checked().data();
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

void MultipleShooting::set_remaining(Bounds first_phase, Bounds total_time) {
  const PhaseDefinition& first = problem().phases().front();
  if (!first.has_free_duration() && !first_phase.is_equality())
    throw DefinitionError(fmt::format("phase '{}': its duration is fixed, not within [{}, {}] s",
                                      first.name, first_phase.lower, first_phase.upper));
  if (first.has_free_duration())  // same as in the constructor of the grid
    for_each_window(first, [&](const Window& window, const auto& describe) {
      for (const std::optional<Instant>* limit : {&window.from, &window.to})
        if (is_after_start(*limit) && (*limit)->seconds() >= first_phase.lower)
          throw DefinitionError(
              fmt::format("phase '{}', {}: its window has a limit at {} s, but the rest of the "
                          "phase may last only {} s",
                          first.name, describe(), (*limit)->seconds(), first_phase.lower));
    });
  else  // a limit between nodes would exclude the interval around it from all windows
    for_each_window(first, [&](const Window& window, const auto& describe) {
      if (window.clock != Clock::phase) return;
      for (const std::optional<Instant>* limit : {&window.from, &window.to})
        if (is_number(*limit) && !grid().has_node_at(0, (*limit)->seconds(), first_phase.lower))
          throw DefinitionError(fmt::format(
              "phase '{}', {}: its window has a limit at {} s, which is not a node if {} s of the "
              "phase remain; specify the limit as an event or on Clock::absolute",
              first.name, describe(), (*limit)->seconds(), first_phase.lower));
    });
  change([&](ProblemData& next) {
    if (first.has_free_duration())
      next.duration_bounds.front() = without_sentinels(first_phase);
    else
      next.durations.front() = first_phase.lower;
    next.total_time = without_sentinels(total_time);
  });
}

void MultipleShooting::set_entries(std::string_view name, const VectorRef& values,
                                   std::span<const ParameterEntry> entries) {
  check_data(problem(), name, static_cast<int>(values.size()), entries);
  for (int i = 0; i < values.size(); ++i)  // message with the given name
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
  if (!checked().set_penalty_weight(weight_name, weight))
    throw DefinitionError(
        fmt::format("problem '{}' has no penalty weight '{}'", problem().name(), weight_name));
}

namespace {

// The following functions check properties of the solution that are not part of the program. This
// one checks whether phases end at the declared crossing of their guard, because a plant leaves a
// phase at the first crossing.
void apply_crossing_check(const GridAccuracy& accuracy, Solution& solution) {
  if (!solution.ok()) return;
  const auto wrong =
      std::ranges::find_if(solution.crossings, [&](const Solution::GuardCrossing& c) {
        return c.has_wrong_direction() || c.early_amount > accuracy.crossing * c.largest;
      });
  if (wrong == solution.crossings.end()) return;
  solution.status = SolveStatus::wrong_crossing;
  solution.message =
      fmt::format("{}; {}", describe(solution.status), describe_crossing_error(*wrong));
}

// First-order conditions also hold at saddle points and maxima. If a solver failed, negative
// curvature of the cost may be the reason.
void check_curvature(MultipleShooting& shooting, const OptimumCheck& check, double most_gain,
                     Solution& solution) {
  using Curvature = OptimumCheck::Curvature;
  const bool gave_up = solution.status == SolveStatus::numerical_failure ||
                       solution.status == SolveStatus::unbounded;
  if (!solution.ok() && !gave_up) return;
  solution.curvature = check.curvature;
  solution.predicted_gain = check.gap + check.gain;
  if (check.variable < 0 || check.curvature == Curvature::minimum) return;
  const std::string where = shooting.nlp().describe_variable(check.variable);
  const bool is_small = check.descent <= most_gain * check.magnitude;
  if (!gave_up && is_small) {
    solution.curvature = Curvature::inconclusive;
    solution.message +=
        fmt::format("; its curvature is inconclusive: second derivatives vanish along {}", where);
    return;
  }
  if (gave_up) {
    solution.message += fmt::format(
        "; the problem is not convex there: its cost has negative curvature along {}", where);
    return;
  }
  solution.predicted_gain = check.descent;
  solution.status = SolveStatus::no_minimum;
  solution.message = fmt::format(
      "{}; the cost decreases by about {:.2g} if {} changes in either direction (use another "
      "guess, or add bounds)",
      describe(solution.status), check.descent, where);
}

// Reports a start whose values overflow. The cost of such values is not unbounded; it cannot be
// computed.
void check_magnitudes(MultipleShooting& shooting, const NlpPoint& start, Solution& solution) {
  if (solution.status != SolveStatus::unbounded &&
      solution.status != SolveStatus::evaluation_failed)
    return;
  for (int i = 0; i < start.w.size(); ++i) {
    if (!(std::abs(start.w[i]) >= no_bound)) continue;
    solution.status = SolveStatus::evaluation_failed;
    solution.message = fmt::format(
        "{}; {} is {:.3g} at the start, which is too large: values of {:g} and more overflow; use "
        "other units, or declare the nominal magnitude",
        describe(solution.status), shooting.nlp().describe_variable(i), start.w[i], no_bound);
    return;
  }
}

// Explains failures that are due to an unbounded cost. Solvers report the limit that they reached
// first, and the defects of such large numbers have no meaning.
void check_descent(MultipleShooting& shooting, const NlpPoint& start, Solution& solution) {
  if (solution.ok() || solution.status == SolveStatus::evaluation_failed) return;
  constexpr double endless = 1e6;  // relative to the cost at the start
  double first = 0.0;
  if (start.w.size() != shooting.nlp().variables() ||
      !shooting.nlp().objective(start.w.data(), first))
    return;
  if (solution.cost < -endless * (1.0 + std::abs(first)))
    solution.message += fmt::format(
        "; the cost decreased from {:.3g} to {:.3g}, so it may be unbounded: add bounds on the "
        "inputs and states that reduce it",
        first, solution.cost);
}

// Reports a residual that meets the tolerance in the solver's scaling, but not in the problem's.
void report_scale_mismatch(const ScaledResult& result, Solution& solution) {
  solution.status = SolveStatus::numerical_failure;
  const std::string miss =
      result.violation > most_violation
          ? fmt::format("constraints are violated by {:.1e} of their magnitude", result.violation)
          : fmt::format("the cost may still decrease by {:.1e} of its magnitude",
                        result.check.relative_gain());
  solution.message = fmt::format(
      "{}; the tolerance is met in the solver's scaling, but {}: declare the magnitudes of states "
      "and inputs (nominal), or use a smaller tolerance",
      describe(solution.status), miss);
}

// Sample points per interval for guards that end phases.
constexpr int samples_inside = 20;

}  // namespace

Solution solve(MultipleShooting& shooting, Solver& solver) {
  return solve(shooting, solver, shooting.initial_guess());
}

Solution solve(MultipleShooting& shooting, Solver& solver, const NlpPoint& start) {
  if (start.w.size() != shooting.nlp().variables())
    throw DefinitionError(
        fmt::format("problem '{}': the start has {} values, but the program has {} variables: use "
                    "initial_guess() or guess_from()",
                    shooting.problem().name(), start.w.size(), shooting.nlp().variables()));
  for (int i = 0; i < start.w.size(); ++i)
    if (!std::isfinite(start.w[i]))
      throw DefinitionError(fmt::format("problem '{}': the guess is not finite: {} is {}",
                                        shooting.problem().name(),
                                        shooting.nlp().describe_variable(i), start.w[i]));
  const bool warm = start.lambda.size() == shooting.nlp().rows();
  ScaledResult result = solve_with_penalties(solver, shooting.editable_program(), start, warm,
                                             shooting.options().automatic_scale);
  Solution solution = shooting.interpret(std::move(result.nlp), samples_inside);
  solution.kkt_in_scale = result.in_scale;
  if (result.is_doubtful) report_scale_mismatch(result, solution);
  check_magnitudes(shooting, start, solution);
  if (!solution.trajectory.empty()) {
    solution.multipliers = multipliers_of(shooting.program(), solution.point);
    check_descent(shooting, start, solution);
    check_curvature(shooting, result.check, most_gain(solver), solution);
    apply_crossing_check(shooting.options().accuracy, solution);
    apply_verification(shooting, solution);
  }
  solution.warnings = shooting.problem().warnings();
  for (const std::string& warning : solution.warnings) solution.message += "; " + warning;
  return solution;
}

}  // namespace saltus
