// Detects which variables, rows and couplings of a StageMap are active. Changed stages get new
// lists.
#include <algorithm>
#include <cmath>

#include "saltus/qp/stage_map_lists.hpp"

namespace saltus::qp {
namespace {

// Negative penalty weights down to this, relative to their terms, are rounding errors.
constexpr double penalty_rounding = 1e-12;

}  // namespace

void StageMap::Lists::mark(int first, int last) {
  for (int k = first; k <= last; ++k) plans[k].dirty = true;
}

StageFill StageMap::Lists::watch(const SparseQp& qp) {
  any_gone = any_fixed_value = false;
  for (const int v : removable) {
    Variable& variable = variables[v];
    const bool gone = qp.lower[v] == qp.upper[v];
    if (gone != variable.gone) {
      variable.gone = gone;
      mark(variable.first, variable.last);
    }
    any_gone = any_gone || gone;
    any_fixed_value = any_fixed_value || (gone && qp.lower[v] != 0.0);
  }
  StageFill result = StageFill::filled;
  for (int k = 0; k < static_cast<int>(plans.size()); ++k)
    for (Group& group : plans[k].groups)
      for (Part& part : group.parts) {
        const bool was_active = part.active;
        if (group.soft) {
          const StageFill soft = watch_soft(qp, part);
          if (soft != StageFill::filled) result = soft;
        } else {
          part.active = qp.row_lower[part.row] > -infinity || qp.row_upper[part.row] < infinity;
        }
        if (part.active == was_active) continue;
        const auto is_on = [&](const Part& p) { return p.row == part.row && p.active; };
        row_active[part.row] = std::ranges::any_of(group.parts, is_on) ? 1 : 0;
        mark(row_first[part.row], k);
      }
  for (Coupling& c : couplings) {
    const bool gone = variables[c.variable].gone;
    const bool on = c.hessian >= 0
                        ? qp.hessian[c.hessian] != 0.0 && !gone && !variables[c.other].gone
                        : row_active[c.row] && !gone;
    if (on == c.on) continue;
    c.on = on;
    mark(variables[c.variable].stage, c.stage);
  }
  return result;
}

// A slack s >= s0 with the cost g s + h/2 s^2 is a violation t = |c| (s - s0) >= 0 of the row
// shifted by c s0, with the penalty l1 t + l2/2 t^2 and a constant.
StageFill StageMap::Lists::watch_soft(const SparseQp& qp, Part& part) const {
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
  part.active = part.l1 > 0.0 || part.l2 > 0.0;  // a free violation does not restrict anything
  return StageFill::filled;
}

bool StageMap::Lists::hold_carried() {
  if (chains == 0) return true;
  for (StagePlan& plan : plans) std::fill(plan.holder.begin(), plan.holder.end(), -1);
  for (const Coupling& c : couplings) {
    if (!c.on) continue;
    const Variable& variable = variables[c.variable];
    for (int k = variable.stage + 1; k <= c.stage; ++k) {
      int& holder = plans[k].holder[variable.chain];
      if (holder >= 0 && holder != c.variable) return false;
      holder = c.variable;
    }
  }
  return true;
}

}  // namespace saltus::qp
