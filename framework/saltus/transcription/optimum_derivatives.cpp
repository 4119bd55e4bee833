#include "saltus/transcription/optimum_derivatives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/solver/optimum_system.hpp"
#include "saltus/transcription/parametric_sensitivity.hpp"
#include "saltus/transcription/quantities.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

// First steps of the extrapolation. Times act through interval lengths, which limit the step.
// Parameters act through formulas that vary over their magnitude.
constexpr double step_of_interval = 0.1;
constexpr double step_of_parameter = 0.05;
constexpr double smallest_of_parameter = 1e-7;
constexpr double smallest_magnitude = 1e-3;  // times the nominal value, for data equal to zero
// Error estimate above which differences do not converge to a derivative.
constexpr double inaccurate = 1e-5;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// Range of steps for times. An event at a node leaves it with the smallest step.
StepRange time_steps(const Grid& grid) {
  double shortest = infinity;
  for (int j = 0; j < grid.phases(); ++j)
    if (grid.nominal_length(j) > 0.0) shortest = std::min(shortest, grid.nominal_length(j));
  if (!std::isfinite(shortest)) shortest = 1.0;
  return {step_of_interval * shortest, 2.0 * same_instant};
}

OptimumSystem system_of(MultipleShooting& shooting, const Solution& solution) {
  const NonlinearProgram& program = shooting.nlp();
  if (solution.point.w.size() != program.variables() ||
      solution.point.lambda.size() != program.rows())
    throw DefinitionError(fmt::format(
        "derivatives of the optimum of problem '{}': the solution has {} variables and {} "
        "multipliers, expected {} and {}",
        shooting.problem().name(), solution.point.w.size(), solution.point.lambda.size(),
        program.variables(), program.rows()));
  return {shooting.nlp(), solution.point, program.curvature_pattern()};
}

}  // namespace

OptimumDerivatives::OptimumDerivatives(MultipleShooting& shooting, const Solution& solution)
    : shooting_(&shooting),
      system_(std::make_unique<OptimumSystem>(system_of(shooting, solution))) {}
OptimumDerivatives::~OptimumDerivatives() = default;
OptimumDerivatives::OptimumDerivatives(OptimumDerivatives&&) noexcept = default;
OptimumDerivatives& OptimumDerivatives::operator=(OptimumDerivatives&&) noexcept = default;

bool OptimumDerivatives::reliable() const { return system_->reliable(); }
const std::string& OptimumDerivatives::message() const { return system_->message(); }
const std::string& OptimumDerivatives::hessian() const { return system_->hessian(); }
const NlpPoint& OptimumDerivatives::point() const { return system_->point(); }

// --- results ------------------------------------------------------------------------------------

OptimumDerivatives::Derivative OptimumDerivatives::unchanged() const {
  OptimumDerivatives::Derivative result;
  OptimumMovement none;
  none.w = VectorXd::Zero(shooting_->nlp().variables());
  finish(result, true, none, 1.0);
  return result;
}

void OptimumDerivatives::finish(OptimumDerivatives::Derivative& result, bool solved,
                                const OptimumMovement& moved, double rate) const {
  const PhaseDefinition& first = shooting_->problem().phases().front();
  const Grid& grid = shooting_->grid();
  if (!system_->is_factored()) result.cost = unknown;
  if (solved)
    result.w = rate * moved.w;
  else
    result.w.setConstant(shooting_->nlp().variables(), unknown);
  int k = 0;  // the first interval of non-zero length
  while (k + 1 < grid.intervals(0) && grid.interval(0, k).is_empty()) ++k;
  result.first_input = result.w.segment(shooting_->layout().input(0, k), first.sizes.nu)
                           .cwiseProduct(first.nominal_input);
  if (result.message.empty()) result.message = system_->message();
  if (result.message.empty() && !solved)
    result.message = "the plan cannot change: the active constraints do not allow it";
  if (result.message.empty()) result.message = moved.one_sided;
  if (result.message.empty() && result.difference_error > inaccurate)
    result.message =
        fmt::format("differences of the program agree only to {:.1g}", result.difference_error);
  result.reliable = result.message.empty();
}

OptimumDerivatives::Derivative OptimumDerivatives::by_differences(const std::string& name,
                                                                  StepRange steps,
                                                                  const EditData& edit) {
  OptimumDerivatives::Derivative result;
  ShootingProgram& program = shooting_->editable_program();
  const ProblemData before = program.data();
  ProblemData data = before;
  const auto move = [&](double d) {
    data = before;
    if (d != 0.0) edit(d, data);
    program.commit(data);
  };
  ParametricRates rates;
  const DifferenceStatus status = difference(program, *system_, steps, move, rates);
  if (status != DifferenceStatus::success) {
    result.cost = unknown;
    result.message =
        status == DifferenceStatus::kink
            ? fmt::format(
                  "costs or constraints have a kink at the current {}: a formula switches there, "
                  "or a sample of a reference is at a node",
                  name)
            : fmt::format(
                  "different constraints or costs are active on either side of the current {}: an "
                  "event or a window limit is at a node or at another event",
                  name);
    finish(result, false, {}, 1.0);
    return result;
  }
  const NlpPoint& point = system_->point();
  result.cost = rates.objective + point.lambda.dot(rates.rows) - point.z.dot(rates.bounds);
  result.difference_error = rates.error;
  OptimumMovement moved;
  const bool solved = system_->solve(rates, moved);
  finish(result, solved, moved, 1.0);
  return result;
}

// The Lagrangian L has the term z (w_i - theta / nominal).
OptimumDerivatives::Derivative OptimumDerivatives::by_holding(int variable, double nominal) {
  OptimumDerivatives::Derivative result;
  OptimumMovement moved;
  const bool solved = system_->hold(variable, moved);
  result.cost = solved ? -system_->point().z[variable] / nominal : unknown;
  finish(result, solved, moved, 1.0 / nominal);
  return result;
}

// --- parameters of the derivative ---------------------------------------------------------------

OptimumDerivatives::Derivative OptimumDerivatives::wrt_event(std::string_view event) {
  const double time = shooting_->data().schedule.time_of(event);
  if (!std::isfinite(time)) return unchanged();
  return by_differences(
      fmt::format("time of event '{}', {} s", event, time), time_steps(shooting_->grid()),
      [&](double d, ProblemData& data) { data.schedule.retime(event, time + d); });
}

// Moves events in an order in which they do not pass one another: the foremost in each direction
// first.
Schedule moved(const Schedule& schedule, std::span<const EventRate> direction, double d) {
  Schedule result = schedule;
  std::vector<EventRate> order(direction.begin(), direction.end());
  std::sort(order.begin(), order.end(), [&](const EventRate& a, const EventRate& b) {
    const bool later = d * a.rate > 0.0;
    if (later != (d * b.rate > 0.0)) return later;
    const int i = schedule.index_of(a.event), j = schedule.index_of(b.event);
    return later ? i > j : i < j;
  });
  for (const EventRate& e : order) result.retime(e.event, schedule.time_of(e.event) + d * e.rate);
  return result;
}

OptimumDerivatives::Derivative OptimumDerivatives::wrt_events(
    std::span<const EventRate> direction) {
  const Schedule schedule = shooting_->data().schedule;
  double fastest = 0.0;
  std::string names;
  for (const EventRate& e : direction) {
    if (!std::isfinite(schedule.time_of(e.event))) return unchanged();
    fastest = std::max(fastest, std::abs(e.rate));
    names += (names.empty() ? "'" : "', '") + e.event;
  }
  if (!(fastest > 0.0)) return unchanged();
  StepRange steps = time_steps(shooting_->grid());
  steps.first /= fastest;
  steps.smallest /= fastest;
  return by_differences(
      fmt::format("times of events {}'", names), steps,
      [&](double d, ProblemData& data) { data.schedule = moved(schedule, direction, d); });
}

OptimumDerivatives::Derivative OptimumDerivatives::wrt_start_time() {
  if (const int v = shooting_->layout().start_time(); v >= 0) return by_holding(v, 1.0);
  const double time = shooting_->data().start_time;
  return by_differences(fmt::format("start time, {} s", time), time_steps(shooting_->grid()),
                        [&](double d, ProblemData& data) { data.start_time = time + d; });
}

OptimumDerivatives::Derivative OptimumDerivatives::wrt_duration(int phase) {
  if (phase < 0 || phase >= shooting_->grid().phases())
    throw DefinitionError(
        fmt::format("problem '{}' has {} phases, but derivatives with respect "
                    "to the duration of phase {} were requested",
                    shooting_->problem().name(), shooting_->grid().phases(), phase));
  const PhaseDefinition& definition = shooting_->problem().phases()[phase];
  if (const int v = shooting_->layout().duration(phase); v >= 0)
    return by_holding(v, definition.nominal_duration);
  const double duration = shooting_->data().durations[phase];
  return by_differences(fmt::format("duration of phase '{}', {} s", definition.name, duration),
                        time_steps(shooting_->grid()),
                        [&](double d, ProblemData& data) { data.durations[phase] = duration + d; });
}

OptimumDerivatives::Derivative OptimumDerivatives::wrt_parameter(std::string_view name, int i) {
  std::vector<std::pair<int, int>> entries;  // pairs (phase, entry of p)
  std::vector<std::string> names;
  const PhaseDefinition::ParameterBlock* found = nullptr;
  for (int j = 0; j < shooting_->grid().phases(); ++j) {
    int first = 0;
    for (const PhaseDefinition::ParameterBlock& block :
         shooting_->problem().phases()[j].parameters) {
      names.push_back(block.name);
      if (block.name == name) {
        found = &block;
        entries.emplace_back(j, first + i);
      }
      first += static_cast<int>(block.value.size());
    }
  }
  if (found == nullptr)
    throw DefinitionError(fmt::format("problem '{}' has no parameter '{}'{}",
                                      shooting_->problem().name(), name,
                                      did_you_mean(name, names)));
  if (i < 0 || i >= found->value.size())
    throw DefinitionError(fmt::format("parameter '{}' has {} entries, but entry {} was requested",
                                      name, found->value.size(), i));
  if (found->unknown)
    return by_holding(shooting_->layout().parameter(entries.front().first, entries.front().second),
                      found->nominal[i]);
  const double value = shooting_->data().parameters[entries.front().first][entries.front().second];
  const double magnitude = datum_magnitude(value, found->nominal[i], smallest_magnitude);
  return by_differences(fmt::format("entry {} of parameter '{}', {}", i, name, value),
                        {step_of_parameter * magnitude, smallest_of_parameter * magnitude},
                        [&](double d, ProblemData& data) {
                          for (const auto& [j, entry] : entries)
                            data.parameters[j][entry] = value + d;
                        });
}

OptimumDerivatives::Derivative OptimumDerivatives::wrt_start(int i) {
  const ShootingProgram& program = shooting_->program();
  const PhaseDefinition& first = shooting_->problem().phases().front();
  if (i < 0 || i >= first.sizes.nx)
    throw DefinitionError(
        fmt::format("the start of problem '{}' has {} states, but entry {} was requested",
                    shooting_->problem().name(), first.sizes.nx, i));
  const int row = program.start_row() + i;
  if (system_->row_side(row) == 0)
    return by_holding(shooting_->layout().state(0, 0) + i, first.nominal_state[i]);
  // Side of a row: g - side decreases with theta.
  OptimumDerivatives::Derivative result;
  const double rate = 1.0 / first.nominal_state[i];
  result.cost = -system_->point().lambda[row] * rate;
  OptimumRates rates = system_->no_rates();
  rates.rows[row] = -rate;
  OptimumMovement moved;
  const bool solved = system_->solve(rates, moved);
  finish(result, solved, moved, 1.0);
  return result;
}

}  // namespace saltus
