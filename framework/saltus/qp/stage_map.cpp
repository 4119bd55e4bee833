// Public functions of StageMap; its lists do the work.
#include "saltus/qp/stage_map.hpp"

#include <algorithm>
#include <utility>

#include "saltus/qp/stage_map_lists.hpp"

namespace saltus {

StageMap::StageMap(const SparseQp& patterns, StageStructure structure)
    : lists_(std::make_unique<Lists>(patterns, std::move(structure))) {}
StageMap::StageMap(StageMap&&) noexcept = default;
StageMap& StageMap::operator=(StageMap&&) noexcept = default;
StageMap::~StageMap() = default;

const StageQp& StageMap::stages() const { return lists_->stages; }

StageFill StageMap::fill(const SparseQp& qp) noexcept { return fill(qp, true); }

StageFill StageMap::fill(const SparseQp& qp, bool rows_changed) noexcept {
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
  if (lists.direct != nullptr && (has_moved || rows_changed) && !lists.direct->write(lists.targets))
    return StageFill::not_staged;
  return lists.write(qp);
}

void StageMap::write_directly(SparseQp& qp, DirectRows& rows) { lists_->write_directly(qp, rows); }
void StageMap::restart(const VectorXd& row_sides) noexcept { lists_->restart(row_sides); }

void StageMap::convert(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) noexcept {
  lists_->to_sparse(qp, from, to);
}

void StageMap::convert(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to) noexcept {
  lists_->to_stages(qp, from, to);
}

}  // namespace saltus
