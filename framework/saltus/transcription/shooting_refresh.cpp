// Data, bounds and weights of ShootingProgram for the current grid. Conventions at events:
// framework/design/conventions.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

namespace {

// Intersects [lower, upper], in multiples of `nominal`, with further bounds.
void intersect(double& lower, double& upper, const Bounds& bounds, double nominal,
               const PhaseDefinition& phase, const char* what, int component) {
  const double lower_before = lower, upper_before = upper;
  lower = std::max(lower, bounds.lower / nominal);
  upper = std::min(upper, bounds.upper / nominal);
  if (!(lower <= upper))
    throw DefinitionError(
        fmt::format("phase '{}', {} {}: bounds that are active at the same time contradict each "
                    "other: [{}, {}] and "
                    "[{}, {}]",
                    phase.name, what, component, lower_before * nominal, upper_before * nominal,
                    bounds.lower, bounds.upper));
}

}  // namespace

void ShootingProgram::refresh() {
  refresh_times();
  refresh_total_time();
  refresh_start();
  refresh_bounds();
  refresh_continuity();
  refresh_rows();
  refresh_limits();
  refresh_costs();
  refresh_changes();
}

void ShootingProgram::refresh_times() {
  for (const BlockInstance& b : placed_) {
    set_constant(b.block, b.time_argument, known_time(b.point));
    if (b.duration_argument >= 0 && layout_.duration(b.point.phase) < 0)
      set_constant(b.block, b.duration_argument, grid_.reference_duration(b.point.phase));
    if (b.length_argument >= 0)
      set_constant(b.block, b.length_argument,
                   grid_.interval(b.point.phase, b.point.interval).length0);
  }
}

void ShootingProgram::refresh_total_time() {
  if (total_time_row_ < 0) return;
  const double known =
      known_start(grid_.phases()) - (layout_.start_time() < 0 ? data_.start_time : 0.0);
  bound_row(total_time_row_, data_.total_time.lower - known, data_.total_time.upper - known);
}

void ShootingProgram::place_data() {
  for (const BlockInstance& b : placed_) {
    const int j = b.point.phase;
    if (b.parameter_argument < 0) continue;
    for (int i = 0; i < data_.parameters[j].size(); ++i)
      if (layout_.parameter(j, i) < 0)
        set_constant(b.block, b.parameter_argument + i, data_.parameters[j][i]);
  }
}

void ShootingProgram::refresh_start() {
  const PhaseDefinition& first = problem_.phases().front();
  for (int i = 0; i < first.sizes.nx; ++i) {
    const int row = start_row_ + i;
    const double lower = data_.start_bounds[i].lower / first.nominal_state[i];
    const double upper = data_.start_bounds[i].upper / first.nominal_state[i];
    if (lower == upper && row_lower()[row] == row_upper()[row])
      move_equality(row, lower);
    else
      bound_row(row, lower, upper);
  }
}

// Sets the bounds of all variables but the slacks.
void ShootingProgram::refresh_bounds() {
  for (int v = 0; v < first_slack_; ++v) bound_variable(v, proposal_.lower[v], proposal_.upper[v]);
  for (int j = 0; j < grid_.phases(); ++j) {
    const PhaseDefinition& phase = problem_.phases()[j];
    int p = 0;
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
      for (int i = 0; i < block.value.size(); ++i, ++p) {
        if (!block.unknown) continue;
        const Bounds b = problem_.bounds_of_unknown(block.name, i);
        bound_variable(layout_.parameter(j, p), b.lower / block.nominal[i],
                       b.upper / block.nominal[i]);
      }
    if (layout_.duration(j) >= 0)
      bound_variable(layout_.duration(j), data_.duration_bounds[j].lower / phase.nominal_duration,
                     data_.duration_bounds[j].upper / phase.nominal_duration);
  }
  if (layout_.start_time() >= 0)
    bound_variable(layout_.start_time(), problem_.start_time_bounds()->lower,
                   problem_.start_time_bounds()->upper);
}

bool ShootingProgram::is_given_start(int phase, int node) const {
  return phase == 0 && grid_.node_offset(0, node) == 0.0 && data_.has_given_start();
}

Bounds ShootingProgram::input_bounds(int phase, int interval, int component) const {
  Bounds result;
  for (const PhaseDefinition::ComponentBounds& b : problem_.phases()[phase].input_bounds) {
    if (b.component != component ||
        !grid_.interval_in(phase, interval, grid_.resolve(phase, b.window)))
      continue;
    result.lower = std::max(result.lower, b.bounds.lower);
    result.upper = std::min(result.upper, b.bounds.upper);
  }
  return result;
}

bool ShootingProgram::is_pinned(int phase, int interval, int component) const {
  const int v = layout_.input(phase, interval) + component;
  return lower()[v] == upper()[v];
}

void ShootingProgram::propose_input_bounds(int j) {
  auto& [grid, lower, upper] = proposal_;
  const PhaseDefinition& phase = problem_.phases()[j];
  const int coefficients = (phase.input_shape() == InputShape::linear ? 2 : 1) * phase.sizes.nu;
  for (int k = 0; k < grid.intervals(j); ++k) {
    // Inputs of an empty slot have no effect. Fix them to zero.
    const double free = grid.interval(j, k).is_empty() ? 0.0 : infinity;
    lower.segment(layout_.input(j, k), coefficients).setConstant(-free);
    upper.segment(layout_.input(j, k), coefficients).setConstant(free);
  }
  for (const PhaseDefinition::ComponentBounds& b : phase.input_bounds) {
    const Grid::PhaseWindow window = grid.resolve(j, b.window);
    const double nominal = phase.nominal_input[b.component];
    for (int k = 0; k < grid.intervals(j); ++k) {
      if (!grid.interval_in(j, k, window)) continue;
      for (int i = b.component; i < coefficients; i += phase.sizes.nu)
        intersect(lower[layout_.input(j, k) + i], upper[layout_.input(j, k) + i], b.bounds, nominal,
                  phase, "input", b.component);
    }
  }
}

void ShootingProgram::propose_state_bounds(int j, bool given_start) {
  auto& [grid, lower, upper] = proposal_;
  const PhaseDefinition& phase = problem_.phases()[j];
  for (int node = 0; node <= grid.intervals(j); ++node) {
    lower.segment(layout_.state(j, node), phase.sizes.nx).setConstant(-infinity);
    upper.segment(layout_.state(j, node), phase.sizes.nx).setConstant(infinity);
    if (given_start && j == 0 && grid.node_offset(0, node) == 0.0) continue;
    for (const PhaseDefinition::ComponentBounds& s : phase.state_bounds) {
      if (!grid.node_in(j, node, grid.resolve(j, s.window))) continue;
      const int v = layout_.state(j, node) + s.component;
      intersect(lower[v], upper[v], s.bounds, phase.nominal_state[s.component], phase, "state",
                s.component);
    }
  }
}

void ShootingProgram::refresh_continuity() {
  for (const IntervalInstance& instance : intervals_) {
    if (instance.continuity_row < 0) continue;
    const int j = instance.phase, node = instance.interval + 1;
    const Grid::Interval &before = grid_.interval(j, node - 1), &after = grid_.interval(j, node);
    const bool meet = !grid_.is_event(j, node) && !before.is_empty() && !after.is_empty();
    const bool is_held = meet && grid_.holds_input(j, node);
    const PhaseDefinition& phase = problem_.phases()[j];
    const bool is_joined =
        is_held ||
        (meet && phase.input_parametrisation == InputParametrisation::piecewise_linear_continuous);
    const double T = grid_.reference_duration(j);
    const bool goes_on = is_held && std::abs(before.length(T) - after.length(T)) <= same_instant;
    const double gap = is_joined ? 0.0 : infinity, bend = goes_on ? 0.0 : infinity;
    for (int i = 0; i < phase.sizes.nu; ++i) {
      bound_row(instance.continuity_row + i, -gap, gap);
      if (instance.slope_row >= 0) bound_row(instance.slope_row + i, -bend, bend);
    }
  }
}

}  // namespace saltus
