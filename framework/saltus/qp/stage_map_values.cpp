// Writes the values of the sparse program into the stages.
#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/stage_map_lists.hpp"

namespace saltus::qp {

StageFill StageMap::Lists::write(const SparseQp& qp, bool with_matrices) {
  StageFill result = StageFill::filled;
  const auto note = [&](StageFill part) {
    if (part != StageFill::filled) result = part;
  };
  if (with_matrices && !write_matrices(qp)) return StageFill::not_staged;
  for (int k = 0; k < static_cast<int>(plans.size()); ++k) {
    write_cost(qp, k);
    note(write_dynamics(qp, k));
    note(write_groups(qp, k));
    write_bounds(qp, k);
  }
  stages.stages.front().constant += qp.constant;
  const StageFill start = write_start(qp);
  return result == StageFill::filled ? start : result;
}

// Returns false if a row of the dynamics does not define its state.
bool StageMap::Lists::write_matrices(const SparseQp& qp) {
  for (StagePlan& plan : plans)
    for (std::size_t i = 0; i < plan.dynamics.size(); ++i) {
      const double d = qp.rows[plan.diagonal[i]];
      if (d == 0.0) return false;
      if (plan.scale[i] == scale_of(d)) continue;
      plan.scale[i] = scale_of(d);
      const int row = plan.dynamics[i];
      for (int e = qp.row_pattern.row_begin(row); e < qp.row_pattern.row_end(row); ++e)
        if (direct == nullptr) targets[e].scale = plan.scale[i];
    }
  for (int e = 0; e < qp.hessian.size(); ++e)
    *hessian_targets[e].to = *hessian_targets[e].mirror = qp.hessian[e];
  for (int e = 0; e < qp.rows.size() && direct == nullptr; ++e)
    *targets[e].to = targets[e].scale * qp.rows[e];
  for (std::size_t k = 0; k < plans.size(); ++k)
    for (std::size_t g = 0; g < plans[k].groups.size(); ++g) {
      double* M = stages.stages[k].groups[g].M.data();
      for (const Twin& twin : plans[k].groups[g].twins) M[twin.to] = M[twin.from];
    }
  return true;
}

void StageMap::Lists::write_cost(const SparseQp& qp, int k) {
  const StagePlan& plan = plans[k];
  Stage& stage = stages.stages[k];
  const double* hessian = qp.hessian.data();
  stage.constant = 0.0;
  const int states = static_cast<int>(plan.states.size());
  for (int i = 0; i < states; ++i) stage.q[i] = plan.is_front ? 0.0 : qp.gradient[plan.states[i]];
  for (int i = states; i < plan.nx; ++i) stage.q[i] = 0.0;
  for (int i = 0; i < plan.nu; ++i) stage.r[i] = qp.gradient[plan.u_variable[i]];
  if (!any_fixed_value) return;
  for (const Fixed& f : plan.cost_fixed) {
    double& slope = f.to < plan.nx ? stage.q[f.to] : stage.r[f.to - plan.nx];
    slope += hessian[f.from] * qp.lower[f.variable];
  }
  for (const Entry& e : plan.cost_constant)
    stage.constant += (e.a == e.b ? 0.5 : 1.0) * hessian[e.from] * qp.lower[e.a] * qp.lower[e.b];
  for (const std::vector<int>* list : {&plan.inputs, &plan.chosen})
    for (const int v : *list)
      if (variables[v].gone) stage.constant += qp.gradient[v] * qp.lower[v];
}

StageFill StageMap::Lists::write_dynamics(const SparseQp& qp, int k) {
  const StagePlan& plan = plans[k];
  VectorXd& b = stages.stages[k].b;
  for (std::size_t i = 0; i < plan.dynamics.size(); ++i) {
    const int row = plan.dynamics[i];
    if (qp.row_lower[row] != qp.row_upper[row]) return StageFill::not_staged;
    b[i] = -plan.scale[i] * qp.row_lower[row];
  }
  if (any_fixed_value)
    for (const Fixed& f : plan.b_fixed)
      b[f.to] += plan.scale[f.to] * qp.rows[f.from] * qp.lower[f.variable];
  return StageFill::filled;
}

StageFill StageMap::Lists::write_groups(const SparseQp& qp, int k) {
  StagePlan& plan = plans[k];
  Stage& stage = stages.stages[k];
  StageFill result = StageFill::filled;
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    Group& group = plan.groups[g];
    RowGroup& target = stage.groups[g];
    if (!group.in_force && !group.soft) continue;
    group.shift.setZero();
    if (any_fixed_value)
      for (const Fixed& f : group.fixed)
        group.shift[f.to] += qp.rows[f.from] * qp.lower[f.variable];
    for (std::size_t p = 0; p < group.parts.size(); ++p) {
      const Part& part = group.parts[p];
      double shift = group.shift[p];
      if (group.soft) {
        const SoftRow& soft = soft_rows[soft_of_row[part.row]];
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
        else if (!(violation_in_tolerances({part.side > 0 ? -infinity : qp.row_lower[part.row],
                                            part.side < 0 ? infinity : qp.row_upper[part.row]},
                                           shift) <= 1.0))
          result = StageFill::infeasible;
        continue;
      }
      target.lower[part.group_row] = lower;
      target.upper[part.group_row] = upper;
      if (group.soft) {
        target.l1[part.group_row] = part.l1;
        target.l2[part.group_row] = part.l2;
      }
    }
  }
  return result;
}

void StageMap::Lists::write_bounds(const SparseQp& qp, int k) {
  const StagePlan& plan = plans[k];
  Stage& stage = stages.stages[k];
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

// Rows of the start: values if all are equalities, otherwise bounds in addition to those of the
// variables. A given start is not a variable of the stages, so its bounds are checked here.
StageFill StageMap::Lists::write_start(const SparseQp& qp) {
  StageFill result = StageFill::filled;
  Stage& first = stages.stages.front();
  stages.fixed_start = true;
  for (const int row : structure.start_rows)
    if (qp.row_lower[row] != qp.row_upper[row]) stages.fixed_start = false;
  for (std::size_t i = 0; i < structure.start_rows.size(); ++i) {
    const int row = structure.start_rows[i];
    const double c = qp.rows[start_entry[i]];
    double lower = qp.row_lower[row] / c, upper = qp.row_upper[row] / c;
    if (stages.fixed_start) stages.start[i] = lower;
    if (c < 0.0) std::swap(lower, upper);
    if (front > 0) {
      first.x_lower[i] = lower;
      first.x_upper[i] = upper;
    } else {
      const double miss = std::max(first.x_lower[i] - lower, lower - first.x_upper[i]);
      if (stages.fixed_start && miss > bound_tolerance(lower)) result = StageFill::infeasible;
      first.x_lower[i] = std::max(first.x_lower[i], lower);
      first.x_upper[i] = std::min(first.x_upper[i], upper);
    }
  }
  return result;
}

}  // namespace saltus::qp
