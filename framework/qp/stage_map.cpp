// StageMap as its users see it; the work is done by its lists.
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

StageFill StageMap::fill(const SparseQp& qp) noexcept {
  Lists& lists = *lists_;
  const StageFill seen = lists.watch(qp);
  if (seen != StageFill::filled) return seen;
  const auto dirty = [](const stage_map::StagePlan& plan) { return plan.dirty; };
  if (std::any_of(lists.plans.begin(), lists.plans.end(), dirty)) {
    if (!lists.hold_carried()) {
      lists.mark(0, static_cast<int>(lists.plans.size()) - 1);
      return StageFill::not_staged;
    }
    lists.make_lists(qp);
  }
  return lists.write(qp);
}

void StageMap::convert(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) noexcept {
  lists_->to_sparse(qp, from, to);
}

void StageMap::convert(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to) noexcept {
  lists_->to_stages(qp, from, to);
}

}  // namespace saltus
