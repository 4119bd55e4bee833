// Rows that are written directly into the stages: the target address of every entry.
#include "saltus/qp/stage_map_lists.hpp"

namespace saltus {

// First all targets point aside. Constant entries, which scale the dynamics, are then also written
// there.
void StageMap::Lists::write_directly(SparseQp& qp, DirectRows& rows) {
  direct = &rows;
  aside = qp.rows.data();
  targets.resize(static_cast<std::size_t>(qp.rows.size()));
  for (std::size_t e = 0; e < targets.size(); ++e) targets[e] = {aside + e, 1.0};
  row_values = VectorXd::Zero(qp.row_pattern.rows());
  for (StagePlan& plan : plans)
    for (Group& group : plan.groups)
      if (group.soft) group.twins.reserve(group.entries.size());
  mark(0, static_cast<int>(plans.size()) - 1);
  rows.write(targets);
}

void StageMap::Lists::aim_dynamics(const SparseQp& qp, int k) {
  StagePlan& plan = plans[k];
  Stage& stage = stages.stages[k];
  const auto scale = [&](int i) {
    const double d = qp.rows[plan.diagonal[i]];
    return d == 1.0 ? -1.0 : -1.0 / d;
  };
  for (const StagePlan::Scaled& m : plan.A) targets[m.from] = {stage.A.data() + m.to, scale(m.row)};
  for (const StagePlan::Scaled& m : plan.B) targets[m.from] = {stage.B.data() + m.to, scale(m.row)};
  for (const Fixed& f : plan.b_fixed) targets[f.from] = {aside + f.from, 1.0};
}

// Targets of inactive rows point aside, so that they do not overwrite active ones.
void StageMap::Lists::aim_group(Group& group, RowGroup& target) {
  group.twins.clear();
  double* M = target.M.data();
  for (const int e : group.entries) targets[e] = {aside + e, 1.0};
  for (const Move& m : group.M) {
    EntryTarget& entry = targets[m.from];
    if (entry.to == aside + m.from)
      entry.to = M + m.to;
    else
      group.twins.push_back({static_cast<int>(entry.to - M), m.to});
  }
}

void StageMap::Lists::restart(const VectorXd& row_sides) {
  for (std::size_t i = 0; i < structure.start_rows.size(); ++i)
    stages.start[i] = row_sides[structure.start_rows[i]] / aside[start_entry[i]];
}

}  // namespace saltus
