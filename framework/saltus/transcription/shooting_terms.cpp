// Set-up of ShootingProgram, continued: blocks of costs, constraints, changes and slacks.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/model/make_function.hpp"
#include "saltus/ocp/cost_functions.hpp"
#include "saltus/ocp/term_reads.hpp"
#include "saltus/transcription/interval_function.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

BlockInstance ShootingProgram::add_term_block(const Function& f, const GridPoint& point,
                                              std::vector<BlockOutput> outputs, bool with_length) {
  const PhaseDefinition& phase = problem_.phases()[point.phase];
  const Arguments& a = phase.sizes;
  const Function function = with_length ? times_length(f) : f;
  Block block(function, std::move(outputs));
  block.coefficients[a.t()] = time_coefficients(point);
  for (int i = 0; i < a.nx; ++i)
    block.coefficients[a.x(i)] = {
        {layout_.state(point.phase, point.node) + i, phase.nominal_state[i]}};
  if (point.interval >= 0)
    for (int i = 0; i < a.nu; ++i)
      block.coefficients[a.u(i)] = {
          {layout_.input(point.phase, point.interval) + (point.at_end ? a.nu : 0) + i,
           phase.nominal_input[i]}};
  for (int i = 0; i < a.np; ++i)
    if (layout_.parameter(point.phase, i) >= 0)
      block.coefficients[a.p(i)] = {
          {layout_.parameter(point.phase, i), phase.nominal_parameter(i)}};
  BlockInstance result{-1, point, a.t(), -1, a.p()};
  if (with_length) {
    result.length_argument = a.size();
    block.coefficients[a.size()] =
        offset_coefficients(point.phase, grid_.interval(point.phase, point.interval).length1);
  }
  result.block = add_block(std::move(block));
  placed_.push_back(result);
  return result;
}

void ShootingProgram::add_row_instance(int j, int t, const GridPoint& point, bool state_only) {
  const Term& term = problem_.phases()[j].terms[t];
  RowInstance instance;
  instance.phase = j;
  instance.term = t;
  instance.state_only = state_only;
  instance.first_row =
      new_rows(term.function.outputs(),
               fmt::format("phase '{}', term '{}', row", problem_.phases()[j].name, term.name));
  row_groups_.back().point = point;
  row_groups_.back().has_point = true;
  std::vector<BlockOutput> outputs;
  for (int i = 0; i < term.function.outputs(); ++i) {
    outputs.push_back({instance.first_row + i, 1.0});
    instance.reads_states_alone.push_back(
        reads_states_alone(problem_.phases()[j].sizes, term.function, i));
  }
  instance.block = add_term_block(term.function, point, std::move(outputs), false);
  rows_.push_back(std::move(instance));
}

void ShootingProgram::build_running(int j, int t, bool integrated) {
  const PhaseDefinition& phase = problem_.phases()[j];
  const Term& term = phase.terms[t];
  const int n = grid_.intervals(j);
  if (term.kind != Term::Kind::constraint) {
    if (integrated) return;  // the integrator evaluates these costs
    const Function f = cost_function(term);
    const bool is_free = layout_.duration(j) >= 0;
    for (int k = 0; k < n; ++k) {
      const BlockInstance b = add_term_block(f, {j, k, k, false}, {BlockOutput{}}, is_free);
      costs_.push_back({j, t, k, b.block, 0, is_free});
    }
    return;
  }
  if (!depends_on_any(term.function, phase.sizes.u(), phase.sizes.nu)) {
    for (int i = 0; i <= n; ++i) add_row_instance(j, t, {.phase = j, .node = i}, true);
    return;
  }
  for (int k = 0; k < n; ++k) {
    add_row_instance(j, t, {j, k, k, false}, false);
    if (phase.input_shape() == InputShape::linear)
      add_row_instance(j, t, {j, k + 1, k, true}, false);
  }
}

void ShootingProgram::build_changes(int j) {
  const PhaseDefinition& phase = problem_.phases()[j];
  const int nu = phase.sizes.nu;
  const Function f = change_costs(phase.input_change_weight);
  const int slots = grid_.intervals(j) - grid_.base_intervals(j);
  // Pairs of neighbours, also across empty slots, for all positions that slots may take.
  const int before_first = j == 0 ? -1 : 0;
  for (int from = before_first; from < grid_.intervals(j); ++from)
    for (int to = from + 1; to <= std::min(from + 1 + slots, grid_.intervals(j) - 1); ++to) {
      Block block(f, std::vector<BlockOutput>(nu));
      for (int i = 0; i < nu; ++i) {
        if (from >= 0)
          block.coefficients[i] = {{layout_.input(j, from) + i, phase.nominal_input[i]}};
        block.coefficients[nu + i] = {{layout_.input(j, to) + i, phase.nominal_input[i]}};
      }
      changes_.push_back({j, from, to, add_block(std::move(block))});
    }
}

// If the length of the paying interval (paying_interval()) is unknown, the cost of a slack is a
// function of both: length(T) x slack, or half its square. Returns the block, or -1 if the length
// is known.
int ShootingProgram::add_penalty_block(const RowInstance& instance, int slack, bool is_quadratic) {
  const Term& term = problem_.phases()[instance.phase].terms[instance.term];
  if (term.domain != Term::Domain::running || layout_.duration(instance.phase) < 0) return -1;
  const int k = paying_interval(instance, grid_.resolve(instance.phase, term.window));
  if (k < 0) return -1;
  const Function cost = times_length(
      is_quadratic
          ? make_function<1, 0, 0>([](const auto&, const auto& s) { return 0.5 * s[0] * s[0]; })
          : make_function<1, 0, 0>([](const auto&, const auto& s) { return s[0]; }));
  Block block(cost, {BlockOutput{}});
  const int length_argument = cost.inputs() - 1;  // (t | slack | length)
  block.coefficients[1] = {{slack, 1.0}};
  block.coefficients[length_argument] =
      offset_coefficients(instance.phase, grid_.interval(instance.phase, k).length1);
  block.constants[length_argument] = grid_.interval(instance.phase, k).length0;
  return add_block(std::move(block));
}

// Slacks come last, so that soft constraints do not change the indices of other variables.
// ocp/term.hpp explains their meaning.
void ShootingProgram::build_slacks() {
  first_slack_ = variables();
  layout_.set_first_slack(first_slack_);
  for (RowInstance& instance : rows_) {
    const Term& term = problem_.phases()[instance.phase].terms[instance.term];
    instance.slack_below.assign(term.function.outputs(), -1);
    instance.slack_above.assign(term.function.outputs(), -1);
    instance.slack_free.assign(term.function.outputs(), -1);
    if (!term.soft) continue;
    const Penalty::Slacks slacks = penalty_slacks(*term.soft);
    const auto add = [&](int row, double sign, const Penalty::SlackCost& cost) {
      const int slack = add_variables(1);
      add_linear(row, slack, sign);
      penalty_blocks_.push_back(add_penalty_block(instance, slack, cost.is_quadratic));
      // With a free duration, the cost has mixed derivatives. Solvers then also need the diagonal
      // entry to convexify.
      if (cost.is_quadratic || penalty_blocks_.back() >= 0) declare_quadratic(slack);
      return slack;
    };
    for (int i = 0; i < term.function.outputs(); ++i) {
      const int row = instance.first_row + i;
      if (std::isfinite(term.bounds[i].lower)) instance.slack_below[i] = add(row, 1.0, slacks.side);
      if (std::isfinite(term.bounds[i].upper))
        instance.slack_above[i] = add(row, -1.0, slacks.side);
      if (slacks.free && !term.bounds[i].is_free())
        instance.slack_free[i] = add(row, 1.0, *slacks.free);
    }
  }
  build_limit_slacks();
  is_lowered_.assign(penalty_blocks_.size(), 0);
}

}  // namespace saltus
