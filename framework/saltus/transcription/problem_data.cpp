#include "saltus/transcription/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "saltus/core/error.hpp"

namespace saltus {

ProblemData::ProblemData(const OptimalControlProblem& problem)
    : start_time(problem.start_time()),
      start_bounds(problem.start_bounds()),
      total_time(problem.total_time()),
      previous_input(VectorXd::Constant(problem.phases().front().sizes.nu,
                                        std::numeric_limits<double>::quiet_NaN())),
      schedule(problem.schedule()) {
  for (const PhaseDefinition& phase : problem.phases()) {
    durations.push_back(phase.has_free_duration() ? phase.duration_guess : phase.duration.lower);
    duration_bounds.push_back(phase.duration);
    VectorXd& p = parameters.emplace_back(phase.sizes.np);
    int i = 0;
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
      for (const double v : block.value) p[i++] = v;
  }
}

bool ProblemData::has_given_start() const {
  return std::all_of(start_bounds.begin(), start_bounds.end(),
                     [](const Bounds& b) { return b.is_equality(); });
}

bool ProblemData::has_same_times(const ProblemData& other) const {
  return start_time == other.start_time && durations == other.durations &&
         duration_bounds == other.duration_bounds && total_time == other.total_time &&
         schedule == other.schedule;
}

namespace {

void check_size(const std::string& what, std::size_t given, std::size_t expected) {
  if (given != expected)
    throw DefinitionError(fmt::format("{}: it has {} entries, expected {}", what, given, expected));
}

void check_start(const OptimalControlProblem& problem, const ProblemData& data) {
  if (!std::isfinite(data.start_time)) throw DefinitionError("the start time is not finite");
  const auto nx = static_cast<std::size_t>(problem.phases().front().sizes.nx);
  if (data.start_bounds.size() != nx)
    check_size("start of problem '" + problem.name() + "'", data.start_bounds.size(), nx);
  for (std::size_t i = 0; i < nx; ++i) {
    const Bounds& b = data.start_bounds[i];
    if (!(b.lower <= b.upper) || (b.is_equality() && !std::isfinite(b.lower)))
      throw DefinitionError(
          fmt::format("start of problem '{}': entry {} is {}", problem.name(), i,
                      b.is_equality() || std::isnan(b.upper) ? b.upper : b.lower));
  }
}

void check_times(const OptimalControlProblem& problem, const ProblemData& data) {
  for (std::size_t j = 0; j < data.durations.size(); ++j) {
    const Bounds& b = data.duration_bounds[j];
    if (!(data.durations[j] >= 0.0) || b.is_empty() || !(b.upper >= 0.0))
      throw DefinitionError(
          fmt::format("phase '{}': the duration {} s with the bounds [{}, {}] s is invalid",
                      problem.phases()[j].name, data.durations[j], b.lower, b.upper));
  }
  if (data.total_time.is_empty())
    throw DefinitionError(fmt::format("problem '{}': the total time has the empty bounds [{}, {}]",
                                      problem.name(), data.total_time.lower,
                                      data.total_time.upper));
}

void check_parameters(const PhaseDefinition& phase, const VectorXd& p) {
  if (p.size() != phase.sizes.np)
    check_size("parameters of phase '" + phase.name + "'", static_cast<std::size_t>(p.size()),
               static_cast<std::size_t>(phase.sizes.np));
  if (p.allFinite()) return;
  int first = 0;
  for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
    for (int i = 0; i < block.value.size(); ++i)
      if (!std::isfinite(p[first + i]))
        throw DefinitionError(
            fmt::format("parameter '{}': entry {} is {}", block.name, i, p[first + i]));
    first += static_cast<int>(block.value.size());
  }
}

void check_previous_input(const PhaseDefinition& first, const VectorXd& input) {
  if (input.size() != first.sizes.nu)
    throw DefinitionError(fmt::format("the previous input has {} entries, but phase '{}' has {}",
                                      input.size(), first.name, first.sizes.nu));
  for (int i = 0; i < input.size(); ++i)
    if (std::isinf(input[i]))
      throw DefinitionError(fmt::format("previous input: entry {} is infinite", i));
}

}  // namespace

void check(const OptimalControlProblem& problem, const ProblemData& data) {
  const std::size_t phases = problem.phases().size();
  check_start(problem, data);
  const std::size_t fewest =
      std::min({data.durations.size(), data.duration_bounds.size(), data.parameters.size()});
  if (fewest != phases || data.durations.size() != phases)
    check_size("phases in the data of problem '" + problem.name() + "'", fewest, phases);
  check_times(problem, data);
  for (std::size_t j = 0; j < phases; ++j)
    check_parameters(problem.phases()[j], data.parameters[j]);
  check_previous_input(problem.phases().front(), data.previous_input);
  Grid::check_events(problem, data.schedule);
}

}  // namespace saltus
