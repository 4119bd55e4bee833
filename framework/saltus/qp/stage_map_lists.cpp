// Destinations of all values of the sparse program in the stages. They change only in stages in
// which a variable, row or coupling appeared or vanished.
#include <algorithm>

#include "saltus/qp/stage_map_lists.hpp"

namespace saltus::qp {
namespace {

constexpr int elsewhere = -2;  // result of column(): not carried to this stage

// Address of an entry of the Hessian for columns a and b of (x, u).
double* hessian_entry(Stage& s, int a, int b) {
  if (a < s.nx && b < s.nx) return &s.Q(a, b);
  if (a >= s.nx && b >= s.nx) return &s.R(a - s.nx, b - s.nx);
  return &s.S(std::max(a, b) - s.nx, std::min(a, b));
}

}  // namespace

void StageMap::Lists::make_lists(const SparseQp& qp) {
  for (StagePlan& plan : plans)
    if (plan.dirty) count_columns(plan);
  for (int k = 0; k < static_cast<int>(plans.size()); ++k) {
    if (!plans[k].dirty) continue;
    list_cost(k);
    list_dynamics(qp, k);
    list_groups(qp, k);
    stages.stages[k].resultant_size = resultant_size(k);
  }
  for (StagePlan& plan : plans) plan.dirty = false;
}

void StageMap::Lists::count_columns(StagePlan& plan) {
  plan.nx = static_cast<int>(plan.states.size());
  if (!plan.is_front)
    for (int i = 0; i < plan.nx; ++i) variables[plan.states[i]].column = i;
  for (const int v : plan.globals)
    plan.global_column[variables[v].index] = variables[v].gone ? -1 : plan.nx++;
  for (const int chain : plan.chains)
    plan.chain_column[chain] = plan.holder[chain] < 0 ? -1 : plan.nx++;
  plan.nu = 0;
  for (const std::vector<int>* list : {&plan.inputs, &plan.chosen})
    for (const int v : *list) {
      variables[v].column = variables[v].gone ? -1 : plan.nx + plan.nu;
      if (!variables[v].gone) plan.u_variable[plan.nu++] = v;
    }
}

// Index of a variable in (x, u) of a stage; -1 if it is eliminated; `elsewhere` if it belongs to an
// earlier stage and is not carried here.
int StageMap::Lists::column(int v, int stage) const {
  const Variable& variable = variables[v];
  if (variable.gone) return -1;
  if (variable.stage == stage) return variable.column;
  const StagePlan& plan = plans[stage];
  if (variable.kind == Kind::global) return plan.global_column[variable.index];
  return variable.chain >= 0 && plan.holder[variable.chain] == v ? plan.chain_column[variable.chain]
                                                                 : elsewhere;
}

void StageMap::Lists::list_cost(int k) {
  StagePlan& plan = plans[k];
  Stage& stage = stages.stages[k];
  stage.nx = plan.nx;
  stage.nu = plan.nu;
  stage.Q.setZero();
  stage.S.setZero();
  stage.R.setZero();
  for (int i = static_cast<int>(plan.states.size()); i < plan.nx; ++i) {
    stage.x_lower[i] = -infinity;
    stage.x_upper[i] = infinity;
  }
  plan.cost_fixed.clear();
  plan.cost_constant.clear();
  for (const Entry& e : plan.hessian) {
    hessian_targets[e.from] = {&nowhere, &nowhere};
    const bool joins_stages = e.a != e.b && variables[e.a].kind != Kind::global &&
                              variables[e.b].kind != Kind::global &&
                              variables[e.a].stage != variables[e.b].stage;
    const bool a_is_early = variables[e.a].stage < variables[e.b].stage;
    const int early = a_is_early ? e.a : e.b, late = a_is_early ? e.b : e.a;
    if (joins_stages && variables[late].gone && !variables[early].gone) continue;  // in `later`
    const int a = column(e.a, k), b = column(e.b, k);
    if (a == elsewhere || b == elsewhere) continue;  // the entry is zero
    if (a < 0 && b < 0) {
      plan.cost_constant.push_back(e);
    } else if (a < 0 || b < 0) {
      plan.cost_fixed.push_back({e.from, std::max(a, b), a < 0 ? e.a : e.b});
    } else {
      hessian_targets[e.from] = {hessian_entry(stage, a, b), hessian_entry(stage, b, a)};
    }
  }
  for (const Entry& e : plan.later)
    if (variables[e.b].gone && !variables[e.a].gone)
      plan.cost_fixed.push_back({e.from, variables[e.a].column, e.b});
}

void StageMap::Lists::list_dynamics(const SparseQp& qp, int k) {
  if (k + 1 == static_cast<int>(plans.size())) return;
  StagePlan& plan = plans[k];
  const StagePlan& next = plans[k + 1];
  Stage& stage = stages.stages[k];
  stage.A.setZero();
  stage.B.setZero();
  stage.b.setZero();
  plan.b_fixed.clear();
  const int nx = plan.nx;
  for (int i = 0; i < static_cast<int>(plan.dynamics.size()); ++i) {
    const int row = plan.dynamics[i];
    const double scale = scale_of(qp.rows[plan.diagonal[i]]);
    for (int e = qp.row_pattern.row_begin(row); e < qp.row_pattern.row_end(row); ++e) {
      if (e == plan.diagonal[i]) continue;
      const int c = column(qp.row_pattern.col(e), k);
      if (c < 0) plan.b_fixed.push_back({e, i, qp.row_pattern.col(e)});
      targets[e] = c < 0
                       ? no_stage(e)
                       : detail::EntryTarget{c < nx ? &stage.A(i, c) : &stage.B(i, c - nx), scale};
    }
  }
  const auto pass = [&](int v, int to) {
    const int c = column(v, k);
    if (c < nx)
      stage.A(to, c) = 1.0;
    else
      stage.B(to, c - nx) = 1.0;
  };
  if (plan.is_front)
    for (int i = 0; i < static_cast<int>(plan.states.size()); ++i) stage.A(i, i) = 1.0;
  for (const int v : next.globals)
    if (!variables[v].gone) pass(v, next.global_column[variables[v].index]);
  for (const int chain : next.chains)
    if (next.holder[chain] >= 0) pass(next.holder[chain], next.chain_column[chain]);
}

void StageMap::Lists::list_groups(const SparseQp& qp, int k) {
  const SparsityPattern& pattern = qp.row_pattern;
  StagePlan& plan = plans[k];
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    Group& group = plan.groups[g];
    RowGroup& target = stages.stages[k].groups[g];
    group.fixed.clear();
    group.twins.clear();
    // Rows that are not active must not overwrite active ones.
    for (const int e : group.entries) targets[e] = no_stage(e);
    target.M.setZero();
    target.rows = 0;
    target.columns.clear();
    group.in_force = std::ranges::any_of(group.parts, &Part::active);
    std::fill(position.begin(), position.end(), -1);
    for (Part& part : group.parts) {
      part.group_row = -1;
      part.constant = true;
      if (!part.active) continue;
      for (int e = pattern.row_begin(part.row); e < pattern.row_end(part.row); ++e) {
        if (variables[pattern.col(e)].kind == Kind::slack) continue;
        const int c = column(pattern.col(e), k);
        if (c < 0) continue;
        part.constant = false;
        position[c] = 0;
      }
      if (!part.constant) part.group_row = target.rows++;
    }
    if (target.rows > 0)
      for (int c = 0; c < plan.nx + plan.nu; ++c)
        if (position[c] == 0) {
          position[c] = static_cast<int>(target.columns.size());
          target.columns.push_back(c);
        }
    const int ld = static_cast<int>(group.parts.size());
    for (int p = 0; p < ld; ++p) {
      const Part& part = group.parts[p];
      if (!part.active) continue;
      for (int e = pattern.row_begin(part.row); e < pattern.row_end(part.row); ++e) {
        const int v = pattern.col(e);
        if (variables[v].kind == Kind::slack) continue;
        const int c = column(v, k);
        if (c < 0) {
          group.fixed.push_back({e, p, v});
          continue;
        }
        const int at = part.group_row + position[c] * ld;
        if (targets[e].to == no_stage(e).to)
          targets[e].to = target.M.data() + at;
        else
          group.twins.push_back({static_cast<int>(targets[e].to - target.M.data()), at});
      }
    }
  }
}

// The declared size if all remaining inputs form whole groups that reach the next stage only
// through the dynamics.
int StageMap::Lists::resultant_size(int k) const {
  const StagePlan& plan = plans[k];
  if (plan.resultants.empty() || plan.nu == 0) return 0;
  int present = 0;
  for (const int first : plan.resultants) {
    int here = 0;
    for (int i = 0; i < plan.resultant_size; ++i) {
      const int v = plan.inputs[first + i];
      if (variables[v].gone) continue;
      ++here;
      if (k + 1 == static_cast<int>(plans.size())) return 0;
      const int chain = variables[v].chain;
      if (chain >= 0 && plans[k + 1].holder[chain] == v) return 0;
    }
    if (here != 0 && here != plan.resultant_size) return 0;
    present += here;
  }
  return present == plan.nu ? plan.resultant_size : 0;
}

}  // namespace saltus::qp
