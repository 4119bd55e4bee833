// Public functions of StageMap, and rows that are written directly into the stages.
#include "saltus/qp/stage_map.hpp"

#include <algorithm>
#include <utility>

#include "saltus/qp/stage_map_lists.hpp"

namespace saltus::qp {

StageMap::StageMap(const SparseQp& patterns, StageStructure structure)
    : lists_(std::make_unique<Lists>(patterns, std::move(structure))) {}
StageMap::StageMap(StageMap&&) noexcept = default;
StageMap& StageMap::operator=(StageMap&&) noexcept = default;
StageMap::~StageMap() = default;

const StageQp& StageMap::stages() const { return lists_->stages; }

StageFill StageMap::fill(const SparseQp& qp, bool matrices_changed) noexcept {
  Lists& lists = *lists_;
  const StageFill seen = lists.watch(qp);
  if (seen != StageFill::filled) return seen;
  const bool has_moved = std::any_of(lists.plans.begin(), lists.plans.end(),
                                     [](const stage_map::StagePlan& plan) { return plan.dirty; });
  if (has_moved) {
    if (!lists.hold_carried()) {
      lists.mark(0, static_cast<int>(lists.plans.size()) - 1);
      return StageFill::not_staged;
    }
    lists.make_lists(qp);
  }
  const bool with_matrices = matrices_changed || has_moved;
  if (lists.direct != nullptr && with_matrices && !lists.direct->write(lists.targets))
    return StageFill::not_staged;
  return lists.write(qp, with_matrices);
}

// First all entries are written to the sparse program, including the constant ones that scale the
// dynamics.
void StageMap::Lists::write_directly(SparseQp& qp, DirectRows& rows) {
  direct = &rows;
  aside = qp.rows.data();
  for (int e = 0; e < qp.rows.size(); ++e) targets[e] = no_stage(e);
  row_values = VectorXd::Zero(qp.row_pattern.rows());
  mark(0, static_cast<int>(plans.size()) - 1);
  rows.write(targets);
}

void StageMap::Lists::restart(const VectorXd& row_sides) {
  for (std::size_t i = 0; i < structure.start_rows.size(); ++i)
    stages.start[i] = row_sides[structure.start_rows[i]] / aside[start_entry[i]];
}

void StageMap::write_directly(SparseQp& qp, DirectRows& rows) { lists_->write_directly(qp, rows); }
void StageMap::restart(const VectorXd& row_sides) noexcept { lists_->restart(row_sides); }

void StageMap::convert(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) noexcept {
  lists_->to_sparse(qp, from, to);
}

void StageMap::convert_part(const SparseQp& qp, const StagePoint& from,
                            PrimalDualPoint& to) noexcept {
  lists_->part_to_sparse(qp, from, to);
}

void StageMap::convert(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to) noexcept {
  lists_->to_stages(qp, from, to);
}

}  // namespace saltus::qp
