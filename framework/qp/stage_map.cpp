// Filling of the stages: what is watched, lists of positions, values along the lists.
#include "saltus/qp/stage_map.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

// A row without variables may be missed by the rounding of its terms.
constexpr double constant_row_tolerance = 1e-9;
// Penalty weights below zero by no more than this, relative to their terms, are rounding.
constexpr double penalty_rounding = 1e-12;

constexpr int elsewhere = -2;  // of column(): not carried here

}  // namespace

void StageMap::mark(int first, int last) {
  for (int k = first; k <= last; ++k) plans_[k].dirty = true;
}

StageFill StageMap::fill(const SparseQp& qp) noexcept {
  const StageFill seen = watch(qp);
  if (seen != StageFill::filled) return seen;
  const bool changed =
      std::any_of(plans_.begin(), plans_.end(), [](const StagePlan& p) { return p.dirty; });
  if (changed) {
    if (!hold_carried()) {
      mark(0, static_cast<int>(plans_.size()) - 1);
      return StageFill::not_staged;
    }
    for (StagePlan& plan : plans_)
      if (plan.dirty) count_columns(plan);
    for (int k = 0; k < static_cast<int>(plans_.size()); ++k) {
      if (!plans_[k].dirty) continue;
      list_cost(k);
      list_dynamics(qp, k);
      list_groups(qp, k);
      stages_.stages[k].resultant_size = resultant_size(k);
    }
    for (StagePlan& plan : plans_) plan.dirty = false;
  }
  StageFill result = StageFill::filled;
  const auto note = [&](StageFill part) {
    if (part != StageFill::filled) result = part;
  };
  for (int k = 0; k < static_cast<int>(plans_.size()); ++k) {
    write_cost(qp, k);
    note(write_dynamics(qp, k));
    note(write_groups(qp, k));
    write_bounds(qp, k);
  }
  stages_.stages.front().constant += qp.constant;
  write_start(qp);
  return result;
}

// --- what is watched ----------------------------------------------------------------------------

StageFill StageMap::watch(const SparseQp& qp) {
  any_fixed_value_ = false;
  for (const int v : removable_) {
    Variable& variable = variables_[v];
    const bool gone = qp.lower[v] == qp.upper[v];
    if (gone != variable.gone) {
      variable.gone = gone;
      mark(variable.first, variable.last);
    }
    any_fixed_value_ = any_fixed_value_ || (gone && qp.lower[v] != 0.0);
  }
  StageFill result = StageFill::filled;
  for (int k = 0; k < static_cast<int>(plans_.size()); ++k)
    for (Group& group : plans_[k].groups)
      for (Part& part : group.parts) {
        const bool was_active = part.active;
        if (group.soft) {
          const StageFill soft = watch_soft(qp, part);
          if (soft != StageFill::filled) result = soft;
        } else {
          part.active = qp.row_lower[part.row] > -infinity || qp.row_upper[part.row] < infinity;
        }
        if (part.active == was_active) continue;
        row_active_[part.row] = part.active ? 1 : 0;
        mark(row_first_[part.row], k);
      }
  for (Coupling& c : couplings_) {
    const bool gone = variables_[c.variable].gone;
    const bool on = c.hessian >= 0
                        ? qp.hessian[c.hessian] != 0.0 && !gone && !variables_[c.other].gone
                        : row_active_[c.row] && !gone;
    if (on == c.on) continue;
    c.on = on;
    mark(variables_[c.variable].stage, c.stage);
  }
  return result;
}

// A slack s >= s0 with the penalty g s + h/2 s^2 is a violation t = |c| (s - s0) >= 0 of the row
// shifted by c s0, with the penalty l1 t + l2/2 t^2 and a constant.
StageFill StageMap::watch_soft(const SparseQp& qp, Part& part) const {
  const double side = part.side < 0 ? qp.row_lower[part.row] : qp.row_upper[part.row];
  part.active = std::isfinite(side);
  if (!part.active) return StageFill::filled;
  const Slack& slack = slack_of(part);
  const double low = qp.lower[slack.variable], c = qp.rows[slack.entry];
  const double curvature = slack.hessian >= 0 ? qp.hessian[slack.hessian] : 0.0;
  if (!std::isfinite(low) || qp.upper[slack.variable] < infinity || !(c * part.side < 0.0))
    return StageFill::not_staged;
  const double slope = qp.gradient[slack.variable], bend = curvature * low;
  part.l1 = (slope + bend) / std::abs(c);
  part.l2 = curvature / (c * c);
  if (part.l1 < 0.0) {
    if (part.l1 * std::abs(c) < -penalty_rounding * (std::abs(slope) + std::abs(bend)))
      return StageFill::not_staged;
    part.l1 = 0.0;
  }
  if (part.l2 < 0.0) return StageFill::not_staged;
  part.active = part.l1 > 0.0 || part.l2 > 0.0;  // what costs nothing restricts nothing
  return StageFill::filled;
}

bool StageMap::hold_carried() {
  if (chains_ == 0) return true;
  for (StagePlan& plan : plans_) std::fill(plan.holder.begin(), plan.holder.end(), -1);
  for (const Coupling& c : couplings_) {
    if (!c.on) continue;
    const Variable& variable = variables_[c.variable];
    for (int k = variable.stage + 1; k <= c.stage; ++k) {
      int& holder = plans_[k].holder[variable.chain];
      if (holder >= 0 && holder != c.variable) return false;
      holder = c.variable;
    }
  }
  return true;
}

void StageMap::count_columns(StagePlan& plan) {
  plan.nx = static_cast<int>(plan.states.size());
  if (!plan.is_front)
    for (int i = 0; i < plan.nx; ++i) variables_[plan.states[i]].column = i;
  for (const int v : plan.globals)
    plan.global_column[variables_[v].index] = variables_[v].gone ? -1 : plan.nx++;
  for (const int chain : plan.chains)
    plan.chain_column[chain] = plan.holder[chain] < 0 ? -1 : plan.nx++;
  plan.nu = 0;
  for (const std::vector<int>* list : {&plan.inputs, &plan.chosen})
    for (const int v : *list) {
      variables_[v].column = variables_[v].gone ? -1 : plan.nx + plan.nu;
      if (!variables_[v].gone) plan.u_variable[plan.nu++] = v;
    }
}

// Where a variable stands in (x, u) of a stage; -1 if it vanished, `elsewhere` if it is of an
// earlier stage and not carried here.
int StageMap::column(int v, int stage) const {
  const Variable& variable = variables_[v];
  if (variable.gone) return -1;
  if (variable.stage == stage) return variable.column;
  const StagePlan& plan = plans_[stage];
  if (variable.kind == Kind::global) return plan.global_column[variable.index];
  return variable.chain >= 0 && plan.holder[variable.chain] == v ? plan.chain_column[variable.chain]
                                                                 : elsewhere;
}

// --- lists --------------------------------------------------------------------------------------

void StageMap::list_cost(int k) {
  StagePlan& plan = plans_[k];
  Stage& stage = stages_.stages[k];
  stage.nx = plan.nx;
  stage.nu = plan.nu;
  stage.Q.setZero();
  stage.S.setZero();
  stage.R.setZero();
  const int nx = plan.nx, ld_x = plan.max_nx, ld_u = plan.max_nu;
  for (int i = static_cast<int>(plan.states.size()); i < nx; ++i) {
    stage.x_lower[i] = -infinity;
    stage.x_upper[i] = infinity;
  }
  plan.Q.clear();
  plan.S.clear();
  plan.R.clear();
  plan.cost_fixed.clear();
  plan.cost_constant.clear();
  for (const Entry& e : plan.hessian) {
    const bool joins_stages = e.a != e.b && variables_[e.a].kind != Kind::global &&
                              variables_[e.b].kind != Kind::global &&
                              variables_[e.a].stage != variables_[e.b].stage;
    const bool a_is_early = variables_[e.a].stage < variables_[e.b].stage;
    const int early = a_is_early ? e.a : e.b, late = a_is_early ? e.b : e.a;
    if (joins_stages && variables_[late].gone && !variables_[early].gone) continue;  // `later`
    const int a = column(e.a, k), b = column(e.b, k);
    if (a == elsewhere || b == elsewhere) continue;  // the entry is zero
    if (a < 0 && b < 0) {
      plan.cost_constant.push_back(e);
    } else if (a < 0 || b < 0) {
      plan.cost_fixed.push_back({e.from, std::max(a, b), a < 0 ? e.a : e.b});
    } else if (a < nx && b < nx) {
      plan.Q.push_back({e.from, a + b * ld_x, b + a * ld_x});
    } else if (a >= nx && b >= nx) {
      plan.R.push_back({e.from, a - nx + (b - nx) * ld_u, b - nx + (a - nx) * ld_u});
    } else {
      plan.S.push_back({e.from, std::max(a, b) - nx + std::min(a, b) * ld_u});
    }
  }
  for (const Entry& e : plan.later)
    if (variables_[e.b].gone && !variables_[e.a].gone)
      plan.cost_fixed.push_back({e.from, variables_[e.a].column, e.b});
}

void StageMap::list_dynamics(const SparseQp& qp, int k) {
  if (k + 1 == static_cast<int>(plans_.size())) return;
  StagePlan& plan = plans_[k];
  const StagePlan& next = plans_[k + 1];
  Stage& stage = stages_.stages[k];
  stage.A.setZero();
  stage.B.setZero();
  stage.b.setZero();
  plan.A.clear();
  plan.B.clear();
  plan.b_fixed.clear();
  const int nx = plan.nx, ld = next.max_nx;
  for (int i = 0; i < static_cast<int>(plan.dynamics.size()); ++i) {
    const int row = plan.dynamics[i];
    for (int e = qp.row_pattern.row_begin(row); e < qp.row_pattern.row_end(row); ++e) {
      if (e == plan.diagonal[i]) continue;
      const int c = column(qp.row_pattern.col(e), k);
      if (c < 0)
        plan.b_fixed.push_back({e, i, qp.row_pattern.col(e)});
      else if (c < nx)
        plan.A.push_back({e, i + c * ld, i});
      else
        plan.B.push_back({e, i + (c - nx) * ld, i});
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
    if (!variables_[v].gone) pass(v, next.global_column[variables_[v].index]);
  for (const int chain : next.chains)
    if (next.holder[chain] >= 0) pass(next.holder[chain], next.chain_column[chain]);
}

void StageMap::list_groups(const SparseQp& qp, int k) {
  const SparsityPattern& pattern = qp.row_pattern;
  StagePlan& plan = plans_[k];
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    Group& group = plan.groups[g];
    RowGroup& target = stages_.stages[k].groups[g];
    group.M.clear();
    group.fixed.clear();
    target.M.setZero();
    target.rows = 0;
    target.columns.clear();
    std::fill(position_.begin(), position_.end(), -1);
    for (Part& part : group.parts) {
      part.at = -1;
      part.constant = true;
      if (!part.active) continue;
      for (int e = pattern.row_begin(part.row); e < pattern.row_end(part.row); ++e) {
        if (variables_[pattern.col(e)].kind == Kind::slack) continue;
        const int c = column(pattern.col(e), k);
        if (c < 0) continue;
        part.constant = false;
        position_[c] = 0;
      }
      if (!part.constant) part.at = target.rows++;
    }
    if (target.rows > 0)
      for (int c = 0; c < plan.nx + plan.nu; ++c)
        if (position_[c] == 0) {
          position_[c] = static_cast<int>(target.columns.size());
          target.columns.push_back(c);
        }
    const int ld = static_cast<int>(group.parts.size());
    for (int p = 0; p < ld; ++p) {
      const Part& part = group.parts[p];
      if (!part.active) continue;
      for (int e = pattern.row_begin(part.row); e < pattern.row_end(part.row); ++e) {
        const int v = pattern.col(e);
        if (variables_[v].kind == Kind::slack) continue;
        const int c = column(v, k);
        if (c < 0)
          group.fixed.push_back({e, p, v});
        else
          group.M.push_back({e, part.at + position_[c] * ld});
      }
    }
  }
}

// The declared size if all inputs that are left form whole groups and reach the next stage through
// nothing but the dynamics.
int StageMap::resultant_size(int k) const {
  const StagePlan& plan = plans_[k];
  if (plan.resultants.empty() || plan.nu == 0) return 0;
  int present = 0;
  for (const int first : plan.resultants) {
    int here = 0;
    for (int i = 0; i < plan.resultant_size; ++i) {
      const int v = plan.inputs[first + i];
      if (variables_[v].gone) continue;
      ++here;
      if (k + 1 == static_cast<int>(plans_.size())) return 0;
      const int chain = variables_[v].chain;
      if (chain >= 0 && plans_[k + 1].holder[chain] == v) return 0;
    }
    if (here != 0 && here != plan.resultant_size) return 0;
    present += here;
  }
  return present == plan.nu ? plan.resultant_size : 0;
}

// --- values -------------------------------------------------------------------------------------

void StageMap::write_cost(const SparseQp& qp, int k) {
  const StagePlan& plan = plans_[k];
  Stage& stage = stages_.stages[k];
  const double* hessian = qp.hessian.data();
  double *Q = stage.Q.data(), *S = stage.S.data(), *R = stage.R.data();
  for (const MovePair& m : plan.Q) Q[m.to] = Q[m.mirror] = hessian[m.from];
  for (const MovePair& m : plan.R) R[m.to] = R[m.mirror] = hessian[m.from];
  for (const Move& m : plan.S) S[m.to] = hessian[m.from];
  stage.constant = 0.0;
  const int states = static_cast<int>(plan.states.size());
  for (int i = 0; i < states; ++i) stage.q[i] = plan.is_front ? 0.0 : qp.gradient[plan.states[i]];
  for (int i = states; i < plan.nx; ++i) stage.q[i] = 0.0;
  for (int i = 0; i < plan.nu; ++i) stage.r[i] = qp.gradient[plan.u_variable[i]];
  if (!any_fixed_value_) return;
  for (const Fixed& f : plan.cost_fixed) {
    double& slope = f.to < plan.nx ? stage.q[f.to] : stage.r[f.to - plan.nx];
    slope += hessian[f.from] * qp.lower[f.variable];
  }
  for (const Entry& e : plan.cost_constant)
    stage.constant += (e.a == e.b ? 0.5 : 1.0) * hessian[e.from] * qp.lower[e.a] * qp.lower[e.b];
  for (const std::vector<int>* list : {&plan.inputs, &plan.chosen})
    for (const int v : *list)
      if (variables_[v].gone) stage.constant += qp.gradient[v] * qp.lower[v];
}

// d x_next + (row) v = rhs becomes x_next = -(row)/d v + rhs/d.
StageFill StageMap::write_dynamics(const SparseQp& qp, int k) {
  StagePlan& plan = plans_[k];
  Stage& stage = stages_.stages[k];
  for (std::size_t i = 0; i < plan.dynamics.size(); ++i) {
    const int row = plan.dynamics[i];
    const double d = qp.rows[plan.diagonal[i]];
    if (d == 0.0 || qp.row_lower[row] != qp.row_upper[row]) return StageFill::not_staged;
    const double scale = d == 1.0 ? -1.0 : -1.0 / d;
    plan.scale[i] = scale;
    stage.b[i] = -scale * qp.row_lower[row];
  }
  const double *rows = qp.rows.data(), *scale = plan.scale.data();
  double *A = stage.A.data(), *B = stage.B.data();
  for (const StagePlan::Scaled& m : plan.A) A[m.to] = rows[m.from] * scale[m.row];
  for (const StagePlan::Scaled& m : plan.B) B[m.to] = rows[m.from] * scale[m.row];
  if (any_fixed_value_)
    for (const Fixed& f : plan.b_fixed)
      stage.b[f.to] += scale[f.to] * rows[f.from] * qp.lower[f.variable];
  return StageFill::filled;
}

StageFill StageMap::write_groups(const SparseQp& qp, int k) {
  StagePlan& plan = plans_[k];
  Stage& stage = stages_.stages[k];
  StageFill result = StageFill::filled;
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    Group& group = plan.groups[g];
    RowGroup& target = stage.groups[g];
    if (target.rows == 0 && !group.soft && group.fixed.empty()) continue;
    double* M = target.M.data();
    for (const Move& m : group.M) M[m.to] = qp.rows[m.from];
    group.shift.setZero();
    if (any_fixed_value_)
      for (const Fixed& f : group.fixed)
        group.shift[f.to] += qp.rows[f.from] * qp.lower[f.variable];
    for (std::size_t p = 0; p < group.parts.size(); ++p) {
      const Part& part = group.parts[p];
      double shift = group.shift[p];
      if (group.soft) {
        const SoftRow& soft = soft_rows_[soft_of_row_[part.row]];
        for (const Slack* slack : {&soft.below, &soft.above})
          if (slack->variable >= 0) shift += qp.rows[slack->entry] * qp.lower[slack->variable];
        const Slack& own = slack_of(part);
        const double low = qp.lower[own.variable];
        const double h = own.hessian >= 0 ? qp.hessian[own.hessian] : 0.0;
        stage.constant += low * (qp.gradient[own.variable] + 0.5 * h * low);
      }
      if (!part.active) continue;
      const double lower = part.side > 0 ? -infinity : qp.row_lower[part.row] - shift;
      const double upper = part.side < 0 ? infinity : qp.row_upper[part.row] - shift;
      if (part.constant) {
        const double miss = std::max({lower, -upper, 0.0});
        if (group.soft)
          stage.constant += miss * (part.l1 + 0.5 * part.l2 * miss);
        else if (!(miss <= constant_row_tolerance * (1.0 + std::abs(shift))))
          result = StageFill::infeasible;
        continue;
      }
      target.lower[part.at] = lower;
      target.upper[part.at] = upper;
      if (group.soft) {
        target.l1[part.at] = part.l1;
        target.l2[part.at] = part.l2;
      }
    }
  }
  return result;
}

void StageMap::write_bounds(const SparseQp& qp, int k) {
  const StagePlan& plan = plans_[k];
  Stage& stage = stages_.stages[k];
  if (!plan.is_front)
    for (std::size_t i = 0; i < plan.states.size(); ++i) {
      stage.x_lower[i] = qp.lower[plan.states[i]];
      stage.x_upper[i] = qp.upper[plan.states[i]];
    }
  for (int i = 0; i < plan.nu; ++i) {
    stage.u_lower[i] = qp.lower[plan.u_variable[i]];
    stage.u_upper[i] = qp.upper[plan.u_variable[i]];
  }
}

// Rows of the start: values if all are equalities, else bounds beside those of the variables.
void StageMap::write_start(const SparseQp& qp) {
  Stage& first = stages_.stages.front();
  stages_.fixed_start = true;
  for (const int row : structure_.start_rows)
    if (qp.row_lower[row] != qp.row_upper[row]) stages_.fixed_start = false;
  for (std::size_t i = 0; i < structure_.start_rows.size(); ++i) {
    const int row = structure_.start_rows[i];
    const double c = qp.rows[start_entry_[i]];
    double lower = qp.row_lower[row] / c, upper = qp.row_upper[row] / c;
    if (stages_.fixed_start) stages_.start[i] = lower;
    if (c < 0.0) std::swap(lower, upper);
    if (front_ > 0) {
      first.x_lower[i] = lower;
      first.x_upper[i] = upper;
    } else {
      first.x_lower[i] = std::max(first.x_lower[i], lower);
      first.x_upper[i] = std::min(first.x_upper[i], upper);
    }
  }
}

}  // namespace saltus
