// Data, bounds and weights of ShootingProgram for the present grid. Conventions at events:
// framework/design/conventions.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

// --- times --------------------------------------------------------------------------------------

double ShootingProgram::known_start(int phase) const {
  double t = start_time;
  for (int i = 0; i < phase; ++i)
    if (layout_.duration(i) < 0) t += grid_.reference_duration(i);
  return t;
}

std::vector<VariableCoefficient> ShootingProgram::start_coefficients(int phase) const {
  std::vector<VariableCoefficient> coefficients;
  for (int i = 0; i < phase; ++i)
    if (layout_.duration(i) >= 0)
      coefficients.push_back({layout_.duration(i), problem_.phases()[i].nominal_duration});
  return coefficients;
}

std::vector<VariableCoefficient> ShootingProgram::offset_coefficients(int phase,
                                                                      double slope) const {
  if (layout_.duration(phase) < 0 || slope == 0.0) return {};
  return {{layout_.duration(phase), slope * problem_.phases()[phase].nominal_duration}};
}

double ShootingProgram::known_time(const GridPoint& point) const {
  const double start = known_start(point.phase);
  if (point.node < grid_.intervals(point.phase))
    return start + grid_.interval(point.phase, point.node).offset0;
  const bool is_free = layout_.duration(point.phase) >= 0;
  return start + (is_free ? 0.0 : grid_.reference_duration(point.phase));
}

std::vector<VariableCoefficient> ShootingProgram::time_coefficients(const GridPoint& point) const {
  std::vector<VariableCoefficient> coefficients = start_coefficients(point.phase);
  const double slope = point.node < grid_.intervals(point.phase)
                           ? grid_.interval(point.phase, point.node).offset1
                           : 1.0;
  for (const VariableCoefficient& s : offset_coefficients(point.phase, slope))
    coefficients.push_back(s);
  return coefficients;
}

double ShootingProgram::interval_length(int phase, int k) const {
  return grid_.interval(phase, k).length(grid_.reference_duration(phase));
}

double ShootingProgram::duration_of(int phase, const VectorXd* w) const {
  if (layout_.duration(phase) < 0 || w == nullptr) return grid_.reference_duration(phase);
  return (*w)[layout_.duration(phase)] * problem_.phases()[phase].nominal_duration;
}

double ShootingProgram::start_of(int phase, const VectorXd* w) const {
  double t = start_time;
  for (int i = 0; i < phase; ++i) t += duration_of(i, w);
  return t;
}

double ShootingProgram::time_of(const GridPoint& point, const VectorXd* w) const {
  const double T = duration_of(point.phase, w);
  const double start = start_of(point.phase, w);
  if (point.node == grid_.intervals(point.phase)) return start + T;
  return start + grid_.interval(point.phase, point.node).offset(T);
}

VectorXd ShootingProgram::parameters_of(int phase, const VectorXd* w) const {
  VectorXd p = data[phase];
  if (w != nullptr)
    for (int i = 0; i < p.size(); ++i)
      if (layout_.parameter(phase, i) >= 0)
        p[i] = (*w)[layout_.parameter(phase, i)] * problem_.phases()[phase].nominal_parameter(i);
  return p;
}

// --- what follows the grid ----------------------------------------------------------------------

void ShootingProgram::refresh() {
  refresh_times();
  refresh_total_time();
  refresh_start();
  refresh_unknowns();
  for (int j = 0; j < grid_.phases(); ++j) {
    refresh_input_bounds(j);
    refresh_state_bounds(j);
  }
  refresh_continuity();
  refresh_rows();
  refresh_costs();
  refresh_changes();
}

void ShootingProgram::refresh_times() {
  for (const BlockInstance& b : placed_) {
    set_constant(b.block, b.time_argument, known_time(b.point));
    if (b.length_argument >= 0)
      set_constant(b.block, b.length_argument,
                   grid_.interval(b.point.phase, b.point.interval).length0);
  }
}

void ShootingProgram::refresh_total_time() {
  if (total_time_row_ < 0) return;
  const double known = known_start(grid_.phases()) - start_time;
  bound_row(total_time_row_, problem_.total_time().lower - known,
            problem_.total_time().upper - known);
}

void ShootingProgram::place_data() {
  for (const BlockInstance& b : placed_) {
    const int j = b.point.phase;
    if (b.parameter_argument < 0) continue;
    for (int i = 0; i < data[j].size(); ++i)
      if (layout_.parameter(j, i) < 0) set_constant(b.block, b.parameter_argument + i, data[j][i]);
  }
}

void ShootingProgram::set_data(int phase, int i, double value) {
  if (data[phase][i] == value) return;
  data[phase][i] = value;
  if (layout_.parameter(phase, i) >= 0) return;
  for (const BlockInstance& b : placed_)
    if (b.point.phase == phase && b.parameter_argument >= 0)
      set_constant(b.block, b.parameter_argument + i, value);
}

void ShootingProgram::refresh_start() {
  const PhaseDefinition& first = problem_.phases().front();
  for (int i = 0; i < first.sizes.nx; ++i)
    bound_row(start_row_ + i, start_bounds[i].lower / first.nominal_state[i],
              start_bounds[i].upper / first.nominal_state[i]);
}

void ShootingProgram::refresh_unknowns() {
  for (int j = 0; j < grid_.phases(); ++j) {
    const PhaseDefinition& phase = problem_.phases()[j];
    int p = 0;
    for (const ParameterBlock& block : phase.parameters)
      for (int i = 0; i < block.value.size(); ++i, ++p) {
        if (!block.unknown) continue;
        const Bounds b = problem_.bounds_of_unknown(block.name, i);
        bound_variable(layout_.parameter(j, p), b.lower / block.nominal[i],
                       b.upper / block.nominal[i]);
      }
    if (layout_.duration(j) >= 0)
      bound_variable(layout_.duration(j), phase.duration.lower / phase.nominal_duration,
                     phase.duration.upper / phase.nominal_duration);
  }
}

bool ShootingProgram::is_given_start(int phase, int node) const {
  return phase == 0 && grid_.node_offset(0, node) == 0.0 &&
         std::all_of(start_bounds.begin(), start_bounds.end(),
                     [](const Bounds& b) { return b.is_equality(); });
}

Bounds ShootingProgram::input_bounds(int phase, int interval, int component) const {
  Bounds result;
  for (const ComponentBounds& b : problem_.phases()[phase].input_bounds) {
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

void ShootingProgram::refresh_input_bounds(int j) {
  const PhaseDefinition& phase = problem_.phases()[j];
  const int coefficients = (phase.input_shape() == InputShape::linear ? 2 : 1) * phase.sizes.nu;
  for (int k = 0; k < grid_.intervals(j); ++k) {
    // In an empty slot no time passes, so any value serves: take zero.
    const double free = grid_.interval(j, k).is_empty() ? 0.0 : infinity;
    for (int i = 0; i < coefficients; ++i) bound_variable(layout_.input(j, k) + i, -free, free);
  }
  for (const ComponentBounds& b : phase.input_bounds) {
    const PhaseWindow window = grid_.resolve(j, b.window);
    const double nominal = phase.nominal_input[b.component];
    for (int k = 0; k < grid_.intervals(j); ++k) {
      if (!grid_.interval_in(j, k, window)) continue;
      for (int i = b.component; i < coefficients; i += phase.sizes.nu) {
        const int v = layout_.input(j, k) + i;
        bound_variable(v, std::max(lower()[v], b.bounds.lower / nominal),
                       std::min(upper()[v], b.bounds.upper / nominal));
        if (!(lower()[v] <= upper()[v]))
          throw DefinitionError(
              fmt::format("phase '{}', input {}: bounds that act at the same time exclude one "
                          "another: [{}, {}]",
                          phase.name, b.component, lower()[v] * nominal, upper()[v] * nominal));
      }
    }
  }
}

void ShootingProgram::refresh_state_bounds(int j) {
  const PhaseDefinition& phase = problem_.phases()[j];
  for (int node = 0; node <= grid_.intervals(j); ++node) {
    const bool given = is_given_start(j, node);
    for (int i = 0; i < phase.sizes.nx; ++i)
      bound_variable(layout_.state(j, node) + i, -infinity, infinity);
    if (given) continue;
    for (const ComponentBounds& s : phase.state_bounds) {
      if (!grid_.node_in(j, node, grid_.resolve(j, s.window))) continue;
      const int v = layout_.state(j, node) + s.component;
      const double nominal = phase.nominal_state[s.component];
      bound_variable(v, std::max(lower()[v], s.bounds.lower / nominal),
                     std::min(upper()[v], s.bounds.upper / nominal));
      if (lower()[v] > upper()[v])
        throw DefinitionError(fmt::format(
            "phase '{}', state {}: bounds that act at the same time exclude one another: [{}, {}]",
            phase.name, s.component, lower()[v] * nominal, upper()[v] * nominal));
    }
  }
}

void ShootingProgram::refresh_continuity() {
  for (const IntervalInstance& instance : intervals_) {
    if (instance.continuity_row < 0) continue;
    const bool joined = !grid_.is_event(instance.phase, instance.interval + 1) &&
                        !grid_.interval(instance.phase, instance.interval).is_empty() &&
                        !grid_.interval(instance.phase, instance.interval + 1).is_empty();
    const double gap = joined ? 0.0 : infinity;
    for (int i = 0; i < problem_.phases()[instance.phase].sizes.nu; ++i)
      bound_row(instance.continuity_row + i, -gap, gap);
  }
}

// Running penalties are per unit of time: of the interval that starts at the place if the window
// reaches into it, else of the one that ends there; -1: of none.
int ShootingProgram::paying_interval(const RowInstance& instance, const PhaseWindow& window) const {
  const int j = instance.phase;
  const GridPoint& point = instance.block.point;
  if (!instance.state_only) return point.interval;
  if (point.node < grid_.intervals(j) && grid_.interval_in(j, point.node, window))
    return point.node;
  int k = point.node - 1;
  while (k >= 0 && grid_.interval(j, k).is_empty()) --k;
  return k >= 0 && grid_.interval_in(j, k, window) ? k : -1;
}

double ShootingProgram::slack_cost(int slack, const VectorXd& w) {
  const int block = penalty_block(slack);
  if (block < 0) return variable_cost(slack, w[slack]);
  double price = 0.0;
  evaluate_block(block, w.data(), &price);
  return weight(block, 0) * price;
}

void ShootingProgram::refresh_rows() {
  const Term* last = nullptr;  // instances of one term follow one another
  PhaseWindow window;
  for (const RowInstance& instance : rows_) {
    const Term& term = problem_.phases()[instance.phase].terms[instance.term];
    if (&term != last) window = grid_.resolve(instance.phase, term.window);
    last = &term;
    const GridPoint& point = instance.block.point;
    bool active = true;
    double fraction = 1.0, length = 1.0;
    if (term.domain == TermDomain::running) {
      active = instance.state_only ? grid_.node_in(instance.phase, point.node, window) &&
                                         !is_given_start(instance.phase, point.node)
                                   : grid_.interval_in(instance.phase, point.interval, window);
      if (term.soft) {
        const int k = paying_interval(instance, window);
        // Ramps have rows at both ends of an interval, which share it.
        const bool halves = !instance.state_only &&
                            problem_.phases()[instance.phase].input_shape() == InputShape::linear;
        fraction = halves ? 0.5 : 1.0;
        length = k < 0 ? 0.0 : interval_length(instance.phase, k);
        active = active && length > 0.0;
      }
    }
    for (int i = 0; i < term.function.outputs(); ++i) {
      const Bounds b = active ? term.bounds[i] : unbounded();
      bound_row(instance.first_row + i, b.lower, b.upper);
      for (const int slack : {instance.slack_below[i], instance.slack_above[i]}) {
        if (slack < 0) continue;
        bound_variable(slack, 0.0, active ? infinity : 0.0);
        const double rate = active ? term.soft->weight * fraction : 0.0;
        if (penalty_block(slack) >= 0) {  // the length is in the block
          set_weight(penalty_block(slack), 0, rate);
          continue;
        }
        const double price = rate * length;
        const bool l1 = term.soft->kind == Penalty::L1;
        set_variable_cost(slack, l1 ? price : 0.0, l1 ? 0.0 : price);
      }
    }
  }
}

void ShootingProgram::refresh_costs() {
  const Term* last = nullptr;
  PhaseWindow window;
  for (const CostInstance& instance : costs_) {
    double factor = 1.0;
    if (instance.interval >= 0) {
      const Term& term = problem_.phases()[instance.phase].terms[instance.term];
      if (&term != last) window = grid_.resolve(instance.phase, term.window);
      last = &term;
      const bool active = grid_.interval_in(instance.phase, instance.interval, window);
      const double length =
          instance.length_inside ? 1.0 : grid_.interval(instance.phase, instance.interval).length0;
      factor = active ? length : 0.0;
    }
    set_weight(instance.block, instance.output, factor);
  }
}

// An input that is forced to a value does not exist there, so nothing is charged into or out of
// such an interval; empty slots are skipped over.
void ShootingProgram::refresh_changes() {
  for (const ChangeInstance& instance : changes_) {
    const int j = instance.phase;
    const auto empty = [&](int k) { return grid_.interval(j, k).is_empty(); };
    bool neighbours = !empty(instance.to) && (instance.from < 0 || !empty(instance.from));
    for (int k = instance.from + 1; k < instance.to; ++k) neighbours = neighbours && empty(k);
    const double nominal = grid_.nominal_length(j);
    const double before = instance.from < 0 ? nominal : interval_length(j, instance.from);
    const double mean = 0.5 * (before + interval_length(j, instance.to));
    for (int i = 0; i < problem_.phases()[j].sizes.nu; ++i) {
      const bool existed = instance.from < 0 ? neighbours && !std::isnan(previous_input[i])
                                             : !is_pinned(j, instance.from, i);
      const bool exists = neighbours && existed && !is_pinned(j, instance.to, i);
      set_weight(instance.block, i, exists ? nominal / mean : 0.0);
      if (instance.from < 0) set_constant(instance.block, i, exists ? previous_input[i] : 0.0);
    }
  }
}

}  // namespace saltus
