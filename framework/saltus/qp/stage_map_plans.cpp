// Construction of StageMap: capacity and memory of each stage.
#include <algorithm>
#include <string>
#include <utility>

#include "saltus/qp/stage_map_lists.hpp"

namespace saltus::qp {

void StageMap::Lists::make_plans(const SparseQp& patterns) {
  for (Variable& variable : variables) {
    if (variable.kind == Kind::slack) continue;
    variable.stage += front;
    variable.last += front;
    variable.first += front;
  }
  for (std::size_t r = 0; r < row_stage.size(); ++r) {
    if (row_stage[r] < 0) continue;
    row_stage[r] += front;
    row_first[r] += front;
  }
  for (Coupling& coupling : couplings) coupling.stage += front;

  plans.resize(structure.stages.size() + front);
  for (int k = 0; k < static_cast<int>(plans.size()); ++k) {
    StagePlan& plan = plans[k];
    plan.is_front = k < front;
    plan.global_column.assign(structure.globals.size(), -1);
    plan.chain_column.assign(chains, -1);
    plan.holder.assign(chains, -1);
    plan.states = structure.stages[std::max(k - front, 0)].states;
    if (plan.is_front) continue;
    const StageStructure::Stage& given = structure.stages[k - front];
    plan.inputs = given.inputs;
    plan.dynamics = given.dynamics;
    for (std::size_t i = 0; i < given.dynamics.size(); ++i)
      plan.diagonal.push_back(
          patterns.row_pattern.find(given.dynamics[i], structure.stages[k - front + 1].states[i]));
    std::size_t entries = 0;
    for (const int r : given.dynamics)
      entries += patterns.row_pattern.row_end(r) - patterns.row_pattern.row_begin(r);
    plan.b_fixed.reserve(entries);
    make_groups(patterns, k, given);
    plan.resultants = given.resultants;
    plan.resultant_size = given.resultant_size;
    for (const int first : given.resultants)
      if (given.resultant_size < 1 || first < 0 ||
          first + given.resultant_size > static_cast<int>(given.inputs.size()))
        stage_map::fail("a common resultant of stage " + std::to_string(k - front) +
                        " names inputs that do not exist");
  }
  for (const int v : structure.globals) {
    const Variable& g = variables[v];
    plans[g.stage].chosen.push_back(v);
    for (int k = g.stage + 1; k <= g.last; ++k) plans[k].globals.push_back(v);
  }
  for (const Variable& variable : variables) {
    if (variable.chain < 0) continue;
    for (int k = variable.stage + 1; k <= variable.last; ++k) {
      std::vector<int>& carried = plans[k].chains;
      if (std::find(carried.begin(), carried.end(), variable.chain) == carried.end())
        carried.push_back(variable.chain);
    }
  }
  patterns.hessian_pattern.for_each([&](int a, int b, int entry) {
    if (variables[a].kind == Kind::slack) return;
    const bool two_globals =
        a != b && variables[a].kind == Kind::global && variables[b].kind == Kind::global;
    const int begin = std::max(variables[a].stage, variables[b].stage);
    const int stage = two_globals ? begin + 1 : begin;
    plans[stage].hessian.push_back({entry, a, b});
  });
  for (const Coupling& c : couplings)
    if (c.hessian >= 0)
      plans[variables[c.variable].stage].later.push_back({c.hessian, c.variable, c.other});
}

// Soft rows are separate from hard ones, one side at a time: each side has its own slack and
// penalty.
void StageMap::Lists::make_groups(const SparseQp& patterns, int stage,
                                  const StageStructure::Stage& given) {
  for (const std::vector<int>& rows : given.groups) {
    for (const bool soft : {false, true}) {
      Group group;
      group.soft = soft;
      for (const int r : rows) {
        if ((soft_of_row[r] >= 0) != soft) continue;
        if (!soft) {
          group.parts.push_back({.row = r});
        } else {
          const SoftRow& s = soft_rows[soft_of_row[r]];
          if (s.below.variable >= 0)
            group.parts.push_back({.row = r, .side = -1, .slack = s.below.variable});
          if (s.above.variable >= 0)
            group.parts.push_back({.row = r, .side = 1, .slack = s.above.variable});
        }
      }
      if (group.parts.empty()) continue;
      std::size_t entries = 0;
      for (const Part& part : group.parts)
        for (int e = patterns.row_pattern.row_begin(part.row);
             e < patterns.row_pattern.row_end(part.row); ++e) {
          const int v = patterns.row_pattern.col(e);
          if (variables[v].kind == Kind::slack) continue;
          ++entries;
          group.entries.push_back(e);
          group.variables.push_back(v);
        }
      std::sort(group.variables.begin(), group.variables.end());
      group.variables.erase(std::unique(group.variables.begin(), group.variables.end()),
                            group.variables.end());
      if (soft) group.twins.reserve(entries);
      group.fixed.reserve(entries);
      group.shift = VectorXd::Zero(static_cast<int>(group.parts.size()));
      plans[stage].groups.push_back(std::move(group));
    }
  }
}

void StageMap::Lists::make_stages() {
  std::vector<StageCapacity> capacity;
  std::size_t widest = 0;
  for (StagePlan& plan : plans) {
    plan.max_nx = static_cast<int>(plan.states.size() + plan.globals.size() + plan.chains.size());
    plan.max_nu = static_cast<int>(plan.inputs.size() + plan.chosen.size());
    plan.u_variable.resize(plan.max_nu);
    plan.scale.assign(plan.dynamics.size(), 0.0);
    plan.cost_fixed.reserve(plan.hessian.size() + plan.later.size());
    plan.cost_constant.reserve(plan.hessian.size());
    StageCapacity& c = capacity.emplace_back();
    c.nx = plan.max_nx;
    c.nu = plan.max_nu;
    for (const Group& group : plan.groups)
      c.groups.push_back({static_cast<int>(group.parts.size()),
                          static_cast<int>(group.variables.size()), group.soft});
    widest = std::max(widest, static_cast<std::size_t>(c.nx + c.nu));
  }
  position.assign(widest, -1);
  stages = StageQp(capacity);
  for (std::size_t k = 0; k < plans.size(); ++k)
    for (std::size_t g = 0; g < plans[k].groups.size(); ++g)
      stages.stages[k].groups[g].columns.reserve(plans[k].groups[g].variables.size());
}

}  // namespace saltus::qp
