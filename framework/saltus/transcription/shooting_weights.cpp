// Active terms on the current grid and their weights. Conventions at events:
// framework/design/conventions.md.
#include <cmath>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

// The interval whose length multiplies a running penalty. It starts at the grid point if the window
// extends into it, otherwise it ends there. -1: none.
int ShootingProgram::paying_interval(const RowInstance& instance,
                                     const Grid::PhaseWindow& window) const {
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
  double cost = 0.0;
  evaluate_block(block, w.data(), &cost);
  return weight(block, 0) * cost;
}

void ShootingProgram::refresh_rows() {
  const Term* last = nullptr;  // instances of a term are contiguous
  Grid::PhaseWindow window;
  for (const RowInstance& instance : rows_) {
    const Term& term = problem_.phases()[instance.phase].terms[instance.term];
    if (&term != last) window = grid_.resolve(instance.phase, term.window);
    last = &term;
    const GridPoint& point = instance.block.point;
    bool active = true, at_given_start = false;
    double fraction = 1.0, length = 1.0;
    if (term.domain == Term::Domain::running) {
      active = instance.state_only ? grid_.node_in(instance.phase, point.node, window)
                                   : grid_.interval_in(instance.phase, point.interval, window);
      at_given_start = !point.at_end && is_given_start(instance.phase, point.node);
      if (term.soft) {
        const int k = paying_interval(instance, window);
        // Ramps have rows at both ends of an interval, each with half its length.
        const bool halves = !instance.state_only &&
                            problem_.phases()[instance.phase].input_shape() == InputShape::linear;
        fraction = halves ? 0.5 : 1.0;
        length = k < 0 ? 0.0 : interval_length(instance.phase, k);
        active = active && length > 0.0 && !(at_given_start && instance.state_only);
      }
    }
    for (int i = 0; i < term.function.outputs(); ++i) {
      const bool holds = active && !(at_given_start && instance.reads_states_alone[i]);
      const Bounds b = holds ? term.bounds[i] : unbounded();
      bound_row(instance.first_row + i, b.lower, b.upper);
      if (!term.soft) continue;
      const Penalty::Slacks slacks = penalty_slacks(*term.soft);
      const double beyond = active ? infinity : 0.0, charged = active ? fraction : 0.0;
      for (const int slack : {instance.slack_below[i], instance.slack_above[i]})
        if (slack >= 0) {
          bound_variable(slack, 0.0, beyond);
          charge_slack(slack, slacks.side, charged, length);
        }
      if (const int slack = instance.slack_free[i]; slack >= 0) {
        bound_variable(slack, -beyond, beyond);
        charge_slack(slack, *slacks.free, charged, length);
      }
    }
  }
}

void ShootingProgram::charge_slack(int slack, const Penalty::SlackCost& cost, double fraction,
                                   double length) {
  const bool is_lowered = !cost.is_quadratic && fraction > 0.0 && cost.weight > max_linear_weight_;
  is_lowered_[slack - first_slack_] = is_lowered ? 1 : 0;
  const double rate = (is_lowered ? max_linear_weight_ : cost.weight) * fraction;
  if (const int block = penalty_block(slack); block >= 0) {  // the block contains the length
    set_weight(block, 0, rate);
    return;
  }
  const double weight = rate * length;
  set_variable_cost(slack, cost.is_quadratic ? 0.0 : weight, cost.is_quadratic ? weight : 0.0);
}

void ShootingProgram::limit_linear_weights(double most) {
  max_linear_weight_ = most;
  refresh_rows();
  refresh_limits();
}

std::vector<int> ShootingProgram::lowered_slacks() const {
  std::vector<int> slacks;
  for (std::size_t i = 0; i < is_lowered_.size(); ++i)
    if (is_lowered_[i]) slacks.push_back(first_slack_ + static_cast<int>(i));
  return slacks;
}

void ShootingProgram::refresh_costs() {
  const Term* last = nullptr;
  Grid::PhaseWindow window;
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
      if (instance.switch_argument >= 0)
        set_constant(instance.block, instance.switch_argument, active ? 1.0 : 0.0);
    }
    set_weight(instance.block, instance.output, factor);
  }
}

// Input changes into or out of an interval with a fixed input are not charged. Empty slots are
// skipped.
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
      const bool existed = instance.from < 0 ? neighbours && !std::isnan(data_.previous_input[i])
                                             : !is_pinned(j, instance.from, i);
      const bool exists = neighbours && existed && !is_pinned(j, instance.to, i);
      set_weight(instance.block, i, exists ? nominal / mean : 0.0);
      if (instance.from < 0)
        set_constant(instance.block, i, exists ? data_.previous_input[i] : 0.0);
    }
  }
}

}  // namespace saltus
