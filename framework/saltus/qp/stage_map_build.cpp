// Construction of StageMap: assignment of variables, rows and entries to stages.
#include <algorithm>
#include <string>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/qp/stage_map_lists.hpp"

namespace saltus::qp {

void stage_map::fail(const std::string& what) { throw DefinitionError("stage structure: " + what); }

namespace {

using stage_map::fail;

std::string variable_name(int v) { return "variable " + std::to_string(v); }
std::string row_name(int r) { return "row " + std::to_string(r); }

}  // namespace

// Until assign_chains() stages are numbered as in the structure. make_plans() then includes an
// inserted first stage.
StageMap::Lists::Lists(const SparseQp& patterns, StageStructure given)
    : structure(std::move(given)),
      variables(patterns.variables()),
      row_stage(patterns.row_pattern.rows(), -2),
      row_first(patterns.row_pattern.rows(), -1),
      row_active(patterns.row_pattern.rows(), 0),
      soft_of_row(patterns.row_pattern.rows(), -1),
      gradient(patterns.variables()),
      targets(patterns.row_pattern.entries(), detail::EntryTarget{&nowhere, 1.0}),
      hessian_targets(patterns.hessian_pattern.entries(), HessianTarget{&nowhere, &nowhere}) {
  if (structure.stages.empty()) fail("there is no stage");
  assign_variables();
  assign_rows(patterns);
  find_uses(patterns);
  assign_globals(patterns);
  assign_chains();
  make_plans(patterns);
  make_stages();
}

void StageMap::Lists::assign_variables() {
  const auto set = [&](int v, Kind kind, int stage, int at) {
    if (v < 0 || v >= static_cast<int>(variables.size()))
      fail(variable_name(v) + " does not exist");
    if (variables[v].kind != Kind::none) fail(variable_name(v) + " is named twice");
    variables[v] = {.kind = kind, .stage = stage, .index = at, .last = stage, .first = stage};
  };
  for (int k = 0; k < static_cast<int>(structure.stages.size()); ++k) {
    const StageStructure::Stage& s = structure.stages[k];
    for (std::size_t i = 0; i < s.states.size(); ++i)
      set(s.states[i], Kind::state, k, static_cast<int>(i));
    for (std::size_t i = 0; i < s.inputs.size(); ++i)
      set(s.inputs[i], Kind::input, k, static_cast<int>(i));
  }
  for (std::size_t g = 0; g < structure.globals.size(); ++g)
    set(structure.globals[g], Kind::global, -1, static_cast<int>(g));
  for (const StageStructure::SoftRow& soft : structure.soft_rows)
    for (const int slack : {soft.below, soft.above})
      if (slack >= 0) set(slack, Kind::slack, -1, soft.row);
  for (std::size_t v = 0; v < variables.size(); ++v) {
    const Kind kind = variables[v].kind;
    if (kind == Kind::none) fail(variable_name(static_cast<int>(v)) + " belongs to no stage");
    if (kind == Kind::input || kind == Kind::global) removable.push_back(static_cast<int>(v));
  }
}

void StageMap::Lists::assign_rows(const SparseQp& patterns) {
  constexpr int of_start = -1;
  const auto put_row = [&](int r, int stage) {
    if (r < 0 || r >= static_cast<int>(row_stage.size())) fail(row_name(r) + " does not exist");
    if (row_stage[r] != -2) fail(row_name(r) + " is named twice");
    row_stage[r] = stage;
  };
  const std::vector<StageStructure::Stage>& all = structure.stages;
  for (int k = 0; k < static_cast<int>(all.size()); ++k) {
    const bool last = k + 1 == static_cast<int>(all.size());
    if (all[k].dynamics.size() != (last ? 0 : all[k + 1].states.size()))
      fail("the dynamics of stage " + std::to_string(k) + " do not have a row per next state");
    for (const int r : all[k].dynamics) put_row(r, k);
    for (const std::vector<int>& group : all[k].groups)
      for (const int r : group) put_row(r, k);
  }
  if (structure.start_rows.size() != all.front().states.size())
    fail("the start does not have a row per state");
  for (std::size_t i = 0; i < structure.start_rows.size(); ++i) {
    const int r = structure.start_rows[i];
    put_row(r, of_start);
    const int begin = patterns.row_pattern.row_begin(r);
    if (patterns.row_pattern.row_end(r) != begin + 1 ||
        patterns.row_pattern.col(begin) != all.front().states[i])
      fail(row_name(r) + " of the start is not on its state alone");
    start_entry.push_back(begin);
  }
  for (std::size_t r = 0; r < row_stage.size(); ++r)
    if (row_stage[r] == -2) fail(row_name(static_cast<int>(r)) + " belongs to no stage");
  for (const StageStructure::SoftRow& soft : structure.soft_rows) {
    soft_of_row[soft.row] = static_cast<int>(soft_rows.size());
    const auto find = [&](int v) {
      if (v < 0) return Slack{};
      const int entry = patterns.row_pattern.find(soft.row, v);
      if (entry < 0) fail(variable_name(v) + ", a slack, is not in " + row_name(soft.row));
      return Slack{v, entry, patterns.hessian_pattern.find(v, v)};
    };
    soft_rows.push_back({find(soft.below), find(soft.above)});
  }
}

// Visits all Hessian entries and rows as uses of variables in stages.
void StageMap::Lists::find_uses(const SparseQp& patterns) {
  const auto carry = [&](int v, int stage, Coupling coupling) {
    coupling.variable = v;
    coupling.stage = stage;
    variables[v].last = std::max(variables[v].last, stage);
    couplings.push_back(coupling);
  };
  const auto use_global = [&](int v, int stage) {
    Variable& g = variables[v];  // until assign_globals(): the first stage that uses it
    g.stage = g.stage < 0 ? stage : std::min(g.stage, stage);
    g.last = std::max(g.last, stage);
  };
  patterns.hessian_pattern.for_each([&](int a, int b, int entry) {
    const Kind ka = variables[a].kind, kb = variables[b].kind;
    if (a == b) return;
    if (ka == Kind::slack || kb == Kind::slack)
      fail("a slack shares an entry of the Hessian: " + variable_name(a) + ", " + variable_name(b));
    if (ka == Kind::global && kb == Kind::global) return;  // in assign_globals()
    if (ka == Kind::global) return use_global(a, variables[b].stage);
    if (kb == Kind::global) return use_global(b, variables[a].stage);
    if (variables[a].stage == variables[b].stage) return;
    const int early = variables[a].stage < variables[b].stage ? a : b;
    const int late = early == a ? b : a;
    carry(early, variables[late].stage, {.hessian = entry, .other = late});
    variables[late].first = std::min(variables[late].first, variables[early].stage);
  });
  for (int r = 0; r < patterns.row_pattern.rows(); ++r) {
    const int stage = row_stage[r];
    row_first[r] = stage;
    if (stage < 0) continue;
    const std::vector<int>& dynamics = structure.stages[stage].dynamics;
    const auto defines = std::find(dynamics.begin(), dynamics.end(), r);
    const bool is_dynamics = defines != dynamics.end();
    const int next =
        is_dynamics ? structure.stages[stage + 1].states[defines - dynamics.begin()] : -1;
    row_active[r] = is_dynamics ? 1 : 0;
    if (is_dynamics && !patterns.row_pattern.contains(r, next))
      fail(row_name(r) + " does not contain " + variable_name(next) + ", which it defines");
    for (int e = patterns.row_pattern.row_begin(r); e < patterns.row_pattern.row_end(r); ++e) {
      const int v = patterns.row_pattern.col(e);
      const Variable& variable = variables[v];
      if (v == next) continue;
      if (variable.kind == Kind::global) {
        use_global(v, stage);
      } else if (variable.kind == Kind::slack) {
        if (variable.index != r || is_dynamics)
          fail(variable_name(v) + ", a slack, is in " + row_name(r) + ", which it does not soften");
      } else if (variable.stage > stage) {
        fail(row_name(r) + " of stage " + std::to_string(stage) + " contains " + variable_name(v) +
             " of stage " + std::to_string(variable.stage));
      } else if (variable.stage < stage) {
        row_first[r] = std::min(row_first[r], variable.stage);
        carry(v, stage, {.row = r});
      }
    }
  }
}

void StageMap::Lists::assign_globals(const SparseQp& patterns) {
  for (const int v : structure.globals) {
    Variable& g = variables[v];
    if (g.stage < 0) g.stage = g.last = structure.stages.size() > 1 ? 1 : 0;  // not used anywhere
  }
  patterns.hessian_pattern.for_each([&](int a, int b, int) {
    if (a == b || variables[a].kind != Kind::global || variables[b].kind != Kind::global) return;
    const int meeting = std::max(variables[a].stage, variables[b].stage);
    for (const int v : {a, b}) variables[v].last = std::max(variables[v].last, meeting);
  });
  for (const int v : structure.globals) {
    --variables[v].stage;
    if (variables[v].stage < 0) front = 1;
    variables[v].first = variables[v].stage;
  }
}

void StageMap::Lists::assign_chains() {
  for (const std::vector<int>& chain : structure.carried) {
    bool used = false;
    for (const int v : chain) {
      Variable& variable = variables[v];
      if (variable.kind != Kind::state && variable.kind != Kind::input)
        fail(variable_name(v) + " is carried, but is neither a state nor an input");
      if (variable.last == variable.stage) continue;
      variable.chain = chains;
      used = true;
    }
    if (used) ++chains;
  }
  for (Variable& variable : variables) {
    const bool staged = variable.kind == Kind::state || variable.kind == Kind::input;
    if (staged && variable.last > variable.stage && variable.chain < 0) variable.chain = chains++;
  }
}

}  // namespace saltus::qp
