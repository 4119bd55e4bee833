// Converts points of a StageMap to the sparse program and back.
#include <algorithm>
#include <cmath>

#include "saltus/qp/side_residual.hpp"
#include "saltus/qp/stage_map_lists.hpp"

namespace saltus::qp {

void StageMap::Lists::part_to_sparse(const SparseQp& qp, const StagePoint& from,
                                     PrimalDualPoint& to) {
  to.w.resize(qp.variables());
  to.z.setZero(qp.variables());
  to.lambda.setZero(qp.row_pattern.rows());
  for (int k = 0; k < static_cast<int>(plans.size()); ++k) {
    const StagePlan& plan = plans[k];
    const StagePoint::AtStage& p = from.stages[k];
    const bool given = k == 0 && stages.fixed_start;  // its bounds are not read
    if (!plan.is_front)
      for (std::size_t i = 0; i < plan.states.size(); ++i) {
        to.w[plan.states[i]] = p.x[i];
        to.z[plan.states[i]] = given ? 0.0 : p.x_bound[i];
      }
    for (int i = 0; i < plan.nu; ++i) {
      to.w[plan.u_variable[i]] = p.u[i];
      to.z[plan.u_variable[i]] = p.u_bound[i];
    }
    for (std::size_t i = 0; i < plan.dynamics.size(); ++i)
      to.lambda[plan.dynamics[i]] = plan.scale[i] * p.costate[i];
    for (std::size_t g = 0; g < plan.groups.size(); ++g)
      for (const Part& part : plan.groups[g].parts)
        if (part.group_row >= 0) to.lambda[part.row] += p.group[g][part.group_row];
  }
  for (const int v : removable)
    if (variables[v].gone) to.w[v] = qp.lower[v];
}

void StageMap::Lists::to_sparse(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) {
  part_to_sparse(qp, from, to);
  give_slacks(qp, from, to);
  // The rest follows from stationarity: multipliers of eliminated variables' bounds, of slacks, and
  // of the start.
  if (!stages.fixed_start) {
    const StagePoint::AtStage& first = from.stages.front();
    for (std::size_t i = 0; i < structure.start_rows.size(); ++i) {
      const int row = structure.start_rows[i], v = structure.stages.front().states[i];
      const double c = qp.rows[start_entry[i]], m = first.x_bound[i];
      // The active side is that of the row or that of the variable.
      const double side = (m > 0.0) == (c > 0.0) ? qp.row_upper[row] / c : qp.row_lower[row] / c;
      const bool of_row = front > 0 || (m > 0.0 ? side <= qp.upper[v] : side >= qp.lower[v]);
      if (!of_row) continue;
      to.lambda[row] = m / c;
      if (front == 0) to.z[v] = 0.0;
    }
  }
  // The slope of the cost to go gives the multipliers of the start rows. The gradient of the whole
  // program gives all others; it is needed only if something was eliminated.
  const bool slope_is_known = front == 0;
  if (any_gone || (stages.fixed_start && !slope_is_known)) compute_gradient(qp, to);
  for (const int v : removable)
    if (variables[v].gone) to.z[v] = -gradient[v];
  for (const SoftRow& soft : soft_rows)
    for (const Slack* slack : {&soft.below, &soft.above})
      if (slack->variable >= 0) to.z[slack->variable] = -slope_of(qp, *slack, to);
  if (stages.fixed_start)
    for (std::size_t i = 0; i < structure.start_rows.size(); ++i) {
      const int v = structure.stages.front().states[i];
      const double given = from.stages.front().x_bound[i];  // its bounds are not read
      const double slope =
          slope_is_known ? costate(from, 0, static_cast<int>(i)) - given : gradient[v];
      to.lambda[structure.start_rows[i]] = -slope / qp.rows[start_entry[i]];
    }
}

// Slope of the cost and its row along a slack that no other term contains.
double StageMap::Lists::slope_of(const SparseQp& qp, const Slack& slack,
                                 const PrimalDualPoint& at) const {
  const int v = slack.variable;
  const double curvature = slack.hessian >= 0 ? qp.hessian[slack.hessian] : 0.0;
  return qp.gradient[v] + curvature * at.w[v] +
         qp.rows[slack.entry] * at.lambda[variables[v].index];
}

double StageMap::Lists::row_value(const SparseQp& qp, int row, const VectorXd& w) const {
  if (direct != nullptr) return row_values[row];
  double value = 0.0;
  for (int e = qp.row_pattern.row_begin(row); e < qp.row_pattern.row_end(row); ++e)
    value += qp.rows[e] * w[qp.row_pattern.col(e)];
  return value;
}

// Computes the slacks that the values and multipliers of their rows require, and the multipliers of
// soft rows without variables.
void StageMap::Lists::give_slacks(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) {
  for (const SoftRow& soft : soft_rows)
    for (const Slack* slack : {&soft.below, &soft.above})
      if (slack->variable >= 0) to.w[slack->variable] = qp.lower[slack->variable];
  bool knows_rows = direct == nullptr;  // rows that belong to no stage
  for (std::size_t k = 0; k < plans.size(); ++k)
    for (std::size_t g = 0; g < plans[k].groups.size(); ++g) {
      if (!plans[k].groups[g].soft) continue;
      for (const Part& part : plans[k].groups[g].parts) {
        const double side = part.side < 0 ? qp.row_lower[part.row] : qp.row_upper[part.row];
        if (std::isinf(side)) continue;
        // Only one side can be violated; the other one can only have a rounding error.
        const int below = soft_rows[soft_of_row[part.row]].below.variable;
        if (part.side > 0 && below >= 0 && to.w[below] > qp.lower[below]) continue;
        double miss = 0.0;
        if (part.group_row >= 0) {
          miss = violation_in_stage(static_cast<int>(k), static_cast<int>(g), part, from);
        } else {
          if (!knows_rows) direct->multiply(to.w, row_values);
          knows_rows = true;
          miss = part.side * (row_value(qp, part.row, to.w) - side);
        }
        const double multiplier = part.constant ? 0.0 : part.side * to.lambda[part.row];
        const double t = soft_slack(miss, part.l1, part.l2, multiplier);
        if (!(t > 0.0)) continue;
        const Slack& slack = slack_of(part);
        to.w[slack.variable] += t / std::abs(qp.rows[slack.entry]);
        if (part.constant) to.lambda[part.row] += part.side * (part.l1 + part.l2 * miss);
      }
    }
}

// Violation of a side whose row belongs to the stage.
double StageMap::Lists::violation_in_stage(int k, int g, const Part& part,
                                           const StagePoint& from) const {
  const RowGroup& group = stages.stages[k].groups[g];
  const int nx = stages.stages[k].nx, row = part.group_row;
  double value = 0.0;
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    const int j = group.columns[c];
    const double entry = j < nx ? from.stages[k].x[j] : from.stages[k].u[j - nx];
    value += group.M(row, static_cast<int>(c)) * entry;
  }
  return part.side < 0 ? group.lower[row] - value : value - group.upper[row];
}

// Computes gradient = g + H w + J'lambda + z.
void StageMap::Lists::compute_gradient(const SparseQp& qp, const PrimalDualPoint& at) {
  gradient = qp.gradient + at.z;
  qp.hessian_pattern.for_each([&](int row, int col, int e) {
    gradient[row] += qp.hessian[e] * at.w[col];
    if (row != col) gradient[col] += qp.hessian[e] * at.w[row];
  });
  if (direct != nullptr) {
    direct->add_transposed(at.lambda, gradient);
    return;
  }
  for (int row = 0; row < qp.row_pattern.rows(); ++row) {
    const double lambda = at.lambda[row];
    if (lambda == 0.0) continue;
    for (int e = qp.row_pattern.row_begin(row); e < qp.row_pattern.row_end(row); ++e)
      gradient[qp.row_pattern.col(e)] += qp.rows[e] * lambda;
  }
}

void StageMap::Lists::to_stages(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to) {
  const bool has_multipliers =
      from.lambda.size() == qp.row_pattern.rows() && from.z.size() == qp.variables();
  const auto lambda = [&](int row) { return has_multipliers ? from.lambda[row] : 0.0; };
  const auto z = [&](int v) { return has_multipliers ? from.z[v] : 0.0; };
  for (int k = 0; k < static_cast<int>(plans.size()); ++k) {
    const StagePlan& plan = plans[k];
    StagePoint::AtStage& p = to.stages[k];
    const int states = static_cast<int>(plan.states.size());
    for (int i = 0; i < states; ++i) {
      p.x[i] = from.w[plan.states[i]];
      p.x_bound[i] = plan.is_front ? 0.0 : z(plan.states[i]);
    }
    for (int i = states; i < plan.nx; ++i) p.x_bound[i] = 0.0;
    for (const int v : plan.globals)
      if (!variables[v].gone) p.x[plan.global_column[variables[v].index]] = from.w[v];
    for (const int chain : plan.chains)
      if (plan.holder[chain] >= 0) p.x[plan.chain_column[chain]] = from.w[plan.holder[chain]];
    for (int i = 0; i < plan.nu; ++i) {
      p.u[i] = from.w[plan.u_variable[i]];
      p.u_bound[i] = z(plan.u_variable[i]);
    }
    for (std::size_t g = 0; g < plan.groups.size(); ++g)
      for (const Part& part : plan.groups[g].parts) {
        if (part.group_row < 0) continue;
        const double l = lambda(part.row);
        p.group[g][part.group_row] = part.side == 0  ? l
                                     : part.side < 0 ? std::min(l, 0.0)
                                                     : std::max(l, 0.0);
      }
    for (std::size_t i = 0; i < plan.dynamics.size(); ++i)
      p.costate[i] = lambda(plan.dynamics[i]) / plan.scale[i];
  }
  for (std::size_t i = 0; i < structure.start_rows.size(); ++i) {
    double& m = to.stages.front().x_bound[i];
    m = stages.fixed_start ? 0.0 : m + lambda(structure.start_rows[i]) * qp.rows[start_entry[i]];
  }
  // Costates of carried variables follow from stationarity, last ones first.
  for (int k = static_cast<int>(plans.size()) - 2; k >= 0; --k)
    for (int i = static_cast<int>(plans[k].dynamics.size()); i < plans[k + 1].nx; ++i)
      to.stages[k].costate[i] = has_multipliers ? costate(to, k + 1, i) : 0.0;
}

// Costate of the dynamics that define entry i of the states of this stage.
double StageMap::Lists::costate(const StagePoint& point, int k, int i) const {
  const Stage& s = stages.stages[k];
  const StagePoint::AtStage& p = point.stages[k];
  double sum = s.q[i] + p.x_bound[i] + s.Q.col(i).head(s.nx).dot(p.x.head(s.nx)) +
               s.S.col(i).head(s.nu).dot(p.u.head(s.nu));
  for (std::size_t g = 0; g < s.groups.size(); ++g) {
    const RowGroup& group = s.groups[g];
    const auto at = std::lower_bound(group.columns.begin(), group.columns.end(), i);
    if (at == group.columns.end() || *at != i) continue;
    sum +=
        group.M.col(at - group.columns.begin()).head(group.rows).dot(p.group[g].head(group.rows));
  }
  if (k + 1 < static_cast<int>(plans.size())) {
    const int next = plans[k + 1].nx;
    sum += s.A.col(i).head(next).dot(p.costate.head(next));
  }
  return sum;
}

}  // namespace saltus::qp
