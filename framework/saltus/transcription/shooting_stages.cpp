// Stage of every variable and row of a shooting program.
#include "saltus/transcription/shooting_stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {

using namespace shooting;

namespace {

std::vector<int> range(int first, int count) {
  std::vector<int> result(count);
  std::iota(result.begin(), result.end(), first);
  return result;
}

void append(std::vector<int>& list, int first, int count) {
  for (int i = 0; i < count; ++i) list.push_back(first + i);
}

}  // namespace

qp::StageStructure stage_structure(const ShootingProgram& program) {
  const Grid& grid = program.grid();
  const Layout& layout = program.layout();
  const std::vector<PhaseDefinition>& phases = program.problem().phases();
  qp::StageStructure structure;

  std::vector<int> first_stage;  // per phase
  std::vector<int> stage_of(program.variables(), -1);
  for (int j = 0; j < grid.phases(); ++j) {
    const PhaseDefinition& phase = phases[j];
    first_stage.push_back(static_cast<int>(structure.stages.size()));
    const int nc = (phase.input_shape() == InputShape::constant ? 1 : 2) * phase.sizes.nu;
    for (int k = 0; k <= grid.intervals(j); ++k) {
      qp::StageStructure::Stage& stage = structure.stages.emplace_back();
      const int integrals = static_cast<int>(phase.integrals.size());
      stage.states = range(layout.state(j, k), phase.sizes.nx);
      append(stage.states, layout.integral(j, k), integrals);
      if (k < grid.intervals(j)) {
        stage.inputs = range(layout.input(j, k), nc);
        if (phase.input_shape() == InputShape::constant) {
          stage.resultants = phase.resultants;
          stage.resultant_size = phase.resultant_size;
        }
      } else if (j + 1 < grid.phases()) {
        stage.dynamics = range(program.jump_row(j + 1), phases[j + 1].sizes.nx);
        append(stage.dynamics, program.integral_start_row(j + 1),
               static_cast<int>(phases[j + 1].integrals.size()));
      }
      for (const std::vector<int>* list : {&stage.states, &stage.inputs})
        for (const int v : *list) stage_of[v] = static_cast<int>(structure.stages.size()) - 1;
    }
    // A component's value is carried to the next interval that has it. Ramps carry their end value.
    const int carried = phase.input_shape() == InputShape::constant ? 0 : phase.sizes.nu;
    for (int i = 0; i < phase.sizes.nu; ++i) {
      std::vector<int>& chain = structure.carried.emplace_back();
      for (int k = 0; k < grid.intervals(j); ++k) chain.push_back(layout.input(j, k) + carried + i);
    }
  }
  structure.start_rows = range(program.start_row(), phases.front().sizes.nx);
  append(structure.start_rows, program.integral_start_row(0),
         static_cast<int>(phases.front().integrals.size()));

  for (const IntervalInstance& instance : program.interval_instances()) {
    const int nu = phases[instance.phase].sizes.nu,
              stage = first_stage[instance.phase] + instance.interval;
    structure.stages[stage].dynamics = range(instance.first_row, phases[instance.phase].sizes.nx);
    append(structure.stages[stage].dynamics, instance.integral_row,
           static_cast<int>(phases[instance.phase].integrals.size()));
    if (instance.slope_row >= 0)
      throw DefinitionError(
          fmt::format("phase '{}': its mesh holds ramps that couple more than neighbouring stages; "
                      "use the sparse solver, Ipopt or constant inputs",
                      phases[instance.phase].name));
    if (instance.continuity_row >= 0 && nu > 0)
      structure.stages[stage + 1].groups.push_back(range(instance.continuity_row, nu));
  }
  // A row of a term belongs to the stage of its last variable.
  for (const RowInstance& instance : program.row_instances()) {
    const GridPoint& point = instance.block.point;
    const int here =
        first_stage[instance.phase] + (point.interval >= 0 ? point.interval : point.node);
    std::map<int, std::vector<int>> rows;
    for (int i = 0; i < static_cast<int>(instance.slack_below.size()); ++i) {
      const int row = instance.first_row + i;
      int stage = here;
      const SparsityPattern& pattern = program.jacobian_pattern();
      for (int e = pattern.row_begin(row); e < pattern.row_end(row); ++e)
        stage = std::max(stage, stage_of[pattern.col(e)]);
      rows[stage].push_back(row);
      bool eliminated = false;
      for (const int slack : {instance.slack_below[i], instance.slack_above[i]}) {
        if (slack < 0) continue;
        // If a free duration enters the cost, the slack is an input of the row's stage.
        eliminated = program.penalty_block(slack) < 0;
        if (!eliminated) structure.stages[stage].inputs.push_back(slack);
      }
      if (instance.slack_free[i] >= 0)
        structure.stages[stage].inputs.push_back(instance.slack_free[i]);
      if (eliminated)
        structure.soft_rows.push_back({row, instance.slack_below[i], instance.slack_above[i]});
    }
    for (auto& [stage, group] : rows) structure.stages[stage].groups.push_back(std::move(group));
  }

  // Links and limits of integrals belong to the stage of their latest end. Values from earlier ends
  // are carried there.
  for (const LimitInstance& instance : program.limit_instances()) {
    qp::StageStructure::Stage& stage =
        structure.stages[first_stage[instance.phase] + instance.point.node];
    for (int i = 0; i < instance.count; ++i) {
      const int row = instance.first_row + i, below = instance.slack_below[i],
                above = instance.slack_above[i];
      stage.groups.push_back({row});
      if (instance.slack_free[i] >= 0) stage.inputs.push_back(instance.slack_free[i]);
      if (below >= 0 || above >= 0) structure.soft_rows.push_back({row, below, above});
    }
  }

  // Closing rows belong to the last stage. The first state is carried there.
  if (program.closing_row() >= 0)
    for (int i = 0; i < phases.front().sizes.nx; ++i)
      structure.stages.back().groups.push_back({program.closing_row() + i});

  int last_free = -1;  // index of the phase
  for (int j = 0; j < grid.phases(); ++j) {
    for (int i = 0; i < phases[j].sizes.np; ++i)
      if (layout.parameter(j, i) >= 0) structure.globals.push_back(layout.parameter(j, i));
    if (layout.duration(j) >= 0) {
      structure.globals.push_back(layout.duration(j));
      last_free = j;
    }
  }
  if (layout.start_time() >= 0) structure.globals.push_back(layout.start_time());
  std::sort(structure.globals.begin(), structure.globals.end());
  structure.globals.erase(std::unique(structure.globals.begin(), structure.globals.end()),
                          structure.globals.end());
  if (program.total_time_row() >= 0)
    structure.stages[first_stage[last_free]].groups.push_back({program.total_time_row()});
  return structure;
}

qp::StageStructure ShootingProgram::stages() const { return stage_structure(*this); }

SparsityPattern ShootingProgram::curvature_pattern() const {
  std::vector<std::pair<int, int>> pairs;
  hessian_pattern().for_each([&](int r, int c, int) { pairs.emplace_back(r, c); });
  for (const IntervalInstance& instance : interval_instances()) {
    const int j = instance.phase;
    if (integrators()[j]->has_hessian()) continue;
    std::vector<int> nearby;
    for (int i = 0; i < problem().phases()[j].sizes.nx; ++i)
      nearby.push_back(layout().state(j, instance.interval) + i);
    for (int i = 0; i < integrators()[j]->arguments().nc; ++i)
      nearby.push_back(layout().input(j, instance.interval) + i);
    for (int i = 0; i < data().parameters[j].size(); ++i)
      if (layout().parameter(j, i) >= 0) nearby.push_back(layout().parameter(j, i));
    for (int i = 0; i <= j; ++i)
      if (layout().duration(i) >= 0) nearby.push_back(layout().duration(i));
    if (layout().start_time() >= 0) nearby.push_back(layout().start_time());
    for (const int a : nearby)
      for (const int b : nearby)
        if (a >= b) pairs.emplace_back(a, b);
  }
  return SparsityPattern::from_pairs(variables(), variables(), std::move(pairs));
}

}  // namespace saltus
