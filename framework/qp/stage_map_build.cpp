// Set-up of StageMap: which variable, row and entry belongs to which stage.
#include <algorithm>
#include <string>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/qp/stage_map.hpp"

namespace saltus {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw DefinitionError("stage structure: " + what);
}
std::string variable_name(int v) { return "variable " + std::to_string(v); }
std::string row_name(int r) { return "row " + std::to_string(r); }

}  // namespace

// Stages are counted as in the structure until place_chains() is done; make_places() then counts
// the one that may be put in front.
StageMap::StageMap(const SparseQp& patterns, StageStructure structure)
    : structure_(std::move(structure)),
      variables_(patterns.variables()),
      row_stage_(patterns.row_pattern.rows(), -2),
      row_first_(patterns.row_pattern.rows(), -1),
      row_active_(patterns.row_pattern.rows(), 0),
      soft_of_row_(patterns.row_pattern.rows(), -1),
      gradient_(patterns.variables()) {
  if (structure_.stages.empty()) fail("there is no stage");
  place_variables();
  place_rows(patterns);
  find_uses(patterns);
  place_globals(patterns);
  place_chains();
  make_places(patterns);
  make_stages();
}

void StageMap::place_variables() {
  const auto set = [&](int v, Kind kind, int stage, int at) {
    if (v < 0 || v >= static_cast<int>(variables_.size()))
      fail(variable_name(v) + " does not exist");
    if (variables_[v].kind != Kind::none) fail(variable_name(v) + " has two places");
    variables_[v] = {.kind = kind, .stage = stage, .index = at, .last = stage, .first = stage};
  };
  for (int k = 0; k < static_cast<int>(structure_.stages.size()); ++k) {
    const StageStructure::Stage& s = structure_.stages[k];
    for (std::size_t i = 0; i < s.states.size(); ++i)
      set(s.states[i], Kind::state, k, static_cast<int>(i));
    for (std::size_t i = 0; i < s.inputs.size(); ++i)
      set(s.inputs[i], Kind::input, k, static_cast<int>(i));
  }
  for (std::size_t g = 0; g < structure_.globals.size(); ++g)
    set(structure_.globals[g], Kind::global, -1, static_cast<int>(g));
  for (const StageStructure::SoftRow& soft : structure_.soft_rows)
    for (const int slack : {soft.below, soft.above})
      if (slack >= 0) set(slack, Kind::slack, -1, soft.row);
  for (std::size_t v = 0; v < variables_.size(); ++v) {
    const Kind kind = variables_[v].kind;
    if (kind == Kind::none) fail(variable_name(static_cast<int>(v)) + " belongs to no stage");
    if (kind == Kind::input || kind == Kind::global) removable_.push_back(static_cast<int>(v));
  }
}

void StageMap::place_rows(const SparseQp& patterns) {
  constexpr int of_start = -1;
  const auto put_row = [&](int r, int stage) {
    if (r < 0 || r >= static_cast<int>(row_stage_.size())) fail(row_name(r) + " does not exist");
    if (row_stage_[r] != -2) fail(row_name(r) + " has two places");
    row_stage_[r] = stage;
  };
  const std::vector<StageStructure::Stage>& stages = structure_.stages;
  for (int k = 0; k < static_cast<int>(stages.size()); ++k) {
    const bool last = k + 1 == static_cast<int>(stages.size());
    if (stages[k].dynamics.size() != (last ? 0 : stages[k + 1].states.size()))
      fail("the dynamics of stage " + std::to_string(k) + " do not have a row per next state");
    for (const int r : stages[k].dynamics) put_row(r, k);
    for (const std::vector<int>& group : stages[k].groups)
      for (const int r : group) put_row(r, k);
  }
  if (structure_.start_rows.size() != stages.front().states.size())
    fail("the start does not have a row per state");
  for (std::size_t i = 0; i < structure_.start_rows.size(); ++i) {
    const int r = structure_.start_rows[i];
    put_row(r, of_start);
    const int begin = patterns.row_pattern.row_begin(r);
    if (patterns.row_pattern.row_end(r) != begin + 1 ||
        patterns.row_pattern.col(begin) != stages.front().states[i])
      fail(row_name(r) + " of the start is not on its state alone");
    start_entry_.push_back(begin);
  }
  for (std::size_t r = 0; r < row_stage_.size(); ++r)
    if (row_stage_[r] == -2) fail(row_name(static_cast<int>(r)) + " belongs to no stage");
  for (const StageStructure::SoftRow& soft : structure_.soft_rows) {
    soft_of_row_[soft.row] = static_cast<int>(soft_rows_.size());
    const auto find = [&](int v) {
      if (v < 0) return Slack{};
      const int entry = patterns.row_pattern.find(soft.row, v);
      if (entry < 0) fail(variable_name(v) + ", a slack, is not in " + row_name(soft.row));
      return Slack{v, entry, patterns.hessian_pattern.find(v, v)};
    };
    soft_rows_.push_back({find(soft.below), find(soft.above)});
  }
}

// Every entry of the Hessian and every row, as uses of variables in stages.
void StageMap::find_uses(const SparseQp& patterns) {
  const auto carry = [&](int v, int stage, Coupling coupling) {
    coupling.variable = v;
    coupling.stage = stage;
    variables_[v].last = std::max(variables_[v].last, stage);
    couplings_.push_back(coupling);
  };
  const auto use_global = [&](int v, int stage) {
    Variable& g = variables_[v];  // until place_globals(): the first stage that uses it
    g.stage = g.stage < 0 ? stage : std::min(g.stage, stage);
    g.last = std::max(g.last, stage);
  };
  patterns.hessian_pattern.for_each([&](int a, int b, int entry) {
    const Kind ka = variables_[a].kind, kb = variables_[b].kind;
    if (a == b) return;
    if (ka == Kind::slack || kb == Kind::slack)
      fail("a slack shares an entry of the Hessian: " + variable_name(a) + ", " + variable_name(b));
    if (ka == Kind::global && kb == Kind::global) return;  // in place_globals()
    if (ka == Kind::global) return use_global(a, variables_[b].stage);
    if (kb == Kind::global) return use_global(b, variables_[a].stage);
    if (variables_[a].stage == variables_[b].stage) return;
    const int early = variables_[a].stage < variables_[b].stage ? a : b;
    const int late = early == a ? b : a;
    carry(early, variables_[late].stage, {.hessian = entry, .other = late});
    variables_[late].first = std::min(variables_[late].first, variables_[early].stage);
  });
  for (int r = 0; r < patterns.row_pattern.rows(); ++r) {
    const int stage = row_stage_[r];
    row_first_[r] = stage;
    if (stage < 0) continue;
    const std::vector<int>& dynamics = structure_.stages[stage].dynamics;
    const auto defines = std::find(dynamics.begin(), dynamics.end(), r);
    const bool is_dynamics = defines != dynamics.end();
    const int next =
        is_dynamics ? structure_.stages[stage + 1].states[defines - dynamics.begin()] : -1;
    row_active_[r] = is_dynamics ? 1 : 0;
    if (is_dynamics && !patterns.row_pattern.contains(r, next))
      fail(row_name(r) + " does not contain " + variable_name(next) + ", which it defines");
    for (int e = patterns.row_pattern.row_begin(r); e < patterns.row_pattern.row_end(r); ++e) {
      const int v = patterns.row_pattern.col(e);
      const Variable& variable = variables_[v];
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
        row_first_[r] = std::min(row_first_[r], variable.stage);
        carry(v, stage, {.row = r});
      }
    }
  }
}

void StageMap::place_globals(const SparseQp& patterns) {
  for (const int v : structure_.globals) {
    Variable& g = variables_[v];
    if (g.stage < 0) g.stage = g.last = structure_.stages.size() > 1 ? 1 : 0;  // used nowhere
  }
  patterns.hessian_pattern.for_each([&](int a, int b, int) {
    if (a == b || variables_[a].kind != Kind::global || variables_[b].kind != Kind::global) return;
    const int meeting = std::max(variables_[a].stage, variables_[b].stage);
    for (const int v : {a, b}) variables_[v].last = std::max(variables_[v].last, meeting);
  });
  for (const int v : structure_.globals) {
    --variables_[v].stage;
    if (variables_[v].stage < 0) front_ = 1;
    variables_[v].first = variables_[v].stage;
  }
}

void StageMap::place_chains() {
  for (const std::vector<int>& chain : structure_.carried) {
    bool used = false;
    for (const int v : chain) {
      Variable& variable = variables_[v];
      if (variable.kind != Kind::state && variable.kind != Kind::input)
        fail(variable_name(v) + " is carried, but is neither a state nor an input");
      if (variable.last == variable.stage) continue;
      variable.chain = chains_;
      used = true;
    }
    if (used) ++chains_;
  }
  for (Variable& variable : variables_) {
    const bool staged = variable.kind == Kind::state || variable.kind == Kind::input;
    if (staged && variable.last > variable.stage && variable.chain < 0) variable.chain = chains_++;
  }
}

void StageMap::make_places(const SparseQp& patterns) {
  for (Variable& variable : variables_) {
    if (variable.kind == Kind::slack) continue;
    variable.stage += front_;
    variable.last += front_;
    variable.first += front_;
  }
  for (std::size_t r = 0; r < row_stage_.size(); ++r) {
    if (row_stage_[r] < 0) continue;
    row_stage_[r] += front_;
    row_first_[r] += front_;
  }
  for (Coupling& coupling : couplings_) coupling.stage += front_;

  plans_.resize(structure_.stages.size() + front_);
  for (int k = 0; k < static_cast<int>(plans_.size()); ++k) {
    StagePlan& plan = plans_[k];
    plan.is_front = k < front_;
    plan.global_column.assign(structure_.globals.size(), -1);
    plan.chain_column.assign(chains_, -1);
    plan.holder.assign(chains_, -1);
    plan.states = structure_.stages[std::max(k - front_, 0)].states;
    if (plan.is_front) continue;
    const StageStructure::Stage& given = structure_.stages[k - front_];
    plan.inputs = given.inputs;
    plan.dynamics = given.dynamics;
    for (std::size_t i = 0; i < given.dynamics.size(); ++i)
      plan.diagonal.push_back(patterns.row_pattern.find(
          given.dynamics[i], structure_.stages[k - front_ + 1].states[i]));
    std::size_t entries = 0;
    for (const int r : given.dynamics)
      entries += patterns.row_pattern.row_end(r) - patterns.row_pattern.row_begin(r);
    plan.A.reserve(entries);
    plan.B.reserve(entries);
    plan.b_fixed.reserve(entries);
    make_groups(patterns, k, given);
    plan.resultants = given.resultants;
    plan.resultant_size = given.resultant_size;
    for (const int first : given.resultants)
      if (given.resultant_size < 1 || first < 0 ||
          first + given.resultant_size > static_cast<int>(given.inputs.size()))
        fail("a common resultant of stage " + std::to_string(k - front_) +
             " names inputs that do not exist");
  }
  for (const int v : structure_.globals) {
    const Variable& g = variables_[v];
    plans_[g.stage].chosen.push_back(v);
    for (int k = g.stage + 1; k <= g.last; ++k) plans_[k].globals.push_back(v);
  }
  for (const Variable& variable : variables_) {
    if (variable.chain < 0) continue;
    for (int k = variable.stage + 1; k <= variable.last; ++k) {
      std::vector<int>& chains = plans_[k].chains;
      if (std::find(chains.begin(), chains.end(), variable.chain) == chains.end())
        chains.push_back(variable.chain);
    }
  }
  patterns.hessian_pattern.for_each([&](int a, int b, int entry) {
    if (variables_[a].kind == Kind::slack) return;
    const bool two_globals =
        a != b && variables_[a].kind == Kind::global && variables_[b].kind == Kind::global;
    const int begin = std::max(variables_[a].stage, variables_[b].stage);
    const int stage = two_globals ? begin + 1 : begin;
    plans_[stage].hessian.push_back({entry, a, b});
  });
  for (const Coupling& c : couplings_)
    if (c.hessian >= 0)
      plans_[variables_[c.variable].stage].later.push_back({c.hessian, c.variable, c.other});
}

// Soft rows stand apart from hard ones, one side at a time: each has its own slack and penalty.
void StageMap::make_groups(const SparseQp& patterns, int stage,
                           const StageStructure::Stage& given) {
  for (const std::vector<int>& rows : given.groups) {
    for (const bool soft : {false, true}) {
      Group group;
      group.soft = soft;
      for (const int r : rows) {
        if ((soft_of_row_[r] >= 0) != soft) continue;
        if (!soft) {
          group.parts.push_back({.row = r});
        } else {
          const SoftRow& s = soft_rows_[soft_of_row_[r]];
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
          if (variables_[v].kind == Kind::slack) continue;
          ++entries;
          group.variables.push_back(v);
        }
      std::sort(group.variables.begin(), group.variables.end());
      group.variables.erase(std::unique(group.variables.begin(), group.variables.end()),
                            group.variables.end());
      group.M.reserve(entries);
      group.fixed.reserve(entries);
      group.shift = VectorXd::Zero(static_cast<int>(group.parts.size()));
      plans_[stage].groups.push_back(std::move(group));
    }
  }
}

void StageMap::make_stages() {
  std::vector<StageCapacity> capacity;
  std::size_t widest = 0;
  for (StagePlan& plan : plans_) {
    plan.max_nx = static_cast<int>(plan.states.size() + plan.globals.size() + plan.chains.size());
    plan.max_nu = static_cast<int>(plan.inputs.size() + plan.chosen.size());
    plan.u_variable.resize(plan.max_nu);
    plan.scale.assign(plan.dynamics.size(), 0.0);
    plan.Q.reserve(plan.hessian.size());
    plan.R.reserve(plan.hessian.size());
    plan.S.reserve(plan.hessian.size());
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
  position_.assign(widest, -1);
  stages_ = StageQp(capacity);
  for (std::size_t k = 0; k < plans_.size(); ++k)
    for (std::size_t g = 0; g < plans_[k].groups.size(); ++g)
      stages_.stages[k].groups[g].columns.reserve(plans_[k].groups[g].variables.size());
}

}  // namespace saltus
