// Packing of values per side and equality row once all offsets are known: beta, active sides,
// penalties, right-hand sides. The contribution of a fixed start to a row moves to its side.
#include <algorithm>
#include <cmath>

#include "saltus/qp/packing.hpp"

namespace saltus::qp {

void Packing::fill_sides() {
  std::fill_n(to.active.data(), to.sides, 0.0);
  std::fill_n(to.beta.data(), to.sides, 0.0);
  std::fill_n(to.wanted.data(), to.equalities, 0.0);
  std::fill_n(to.l1.data() + to.first_soft, to.sides - to.first_soft, 1.0);
  std::fill_n(to.l2.data() + to.first_soft, to.sides - to.first_soft, 0.0);
  for (int k = 0; k < static_cast<int>(qp.stages.size()); ++k) {
    for (RowBlock& b : to.stages[k].rows)
      if (b.twin != nullptr)
        fill_like_twin(b);
      else
        fill_rows(k, b);
    fill_bounds(k);
  }
}

void Packing::start() {
  vectors(0);
  for (RowBlock& b : to.stages.front().rows) fill_rows(0, b);
  const Stage& s = qp.stages.front();
  for (int g = 0; g < static_cast<int>(s.groups.size()); ++g)
    for (int row = 0; row < s.groups[g].rows && !s.groups[g].soft; ++row)
      if (!without_sides(s.groups[g].lower[row], s.groups[g].upper[row]))
        depends_on_start_only(0, g, row);  // reports contradictions
}

void Packing::set_side(int side, double value, double sign) {
  if (!std::isfinite(value)) return;
  to.active[side] = 1.0;
  to.beta[side] = sign * value;
}

// Contribution of a fixed start to a row of the first stage.
double Packing::constant_part(const RowGroup& group, int row) const {
  double value = 0.0;
  for (int c = 0; c < static_cast<int>(group.columns.size()); ++c)
    if (group.columns[c] < qp.stages[0].nx) value += group.M(row, c) * qp.start[group.columns[c]];
  return value;
}

void Packing::fill_like_twin(RowBlock& b) {
  b.partial = b.twin->partial;
  const auto copy = [&](AlignedArray& numbers, int from, int first) {
    for (int i = 0; i < padded(b.rows); i += lanes)
      store(&numbers[first + i], load(&numbers[from + i]));
  };
  const int from[] = {b.twin->lower_at, b.twin->upper_at}, first[] = {b.lower_at, b.upper_at};
  for (int side = 0; side < 2; ++side) {
    if (first[side] < 0) continue;
    copy(to.active, from[side], first[side]);
    copy(to.beta, from[side], first[side]);
    if (!b.soft) continue;
    copy(to.l1, from[side], first[side]);
    copy(to.l2, from[side], first[side]);
  }
}

void Packing::fill_rows(int k, RowBlock& b) {
  const Stage& s = qp.stages[k];
  const RowGroup* group = b.group >= 0 ? &s.groups[b.group] : nullptr;
  const bool shifted = group != nullptr && starts_fixed(k);
  for (int i = 0; i < b.rows; ++i) {
    const int from = b.source[i];
    const double l = group != nullptr ? group->lower[from] : lower_bound(s, from);
    const double u = group != nullptr ? group->upper[from] : upper_bound(s, from);
    const double shift = shifted ? constant_part(*group, from) : 0.0;
    if (b.equality_at >= 0) {
      to.wanted[b.equality_at + i] = (l - shift) * b.scale[i];
      continue;
    }
    if (b.lower_at >= 0) set_side(b.lower_at + i, l - shift, 1.0);
    if (b.upper_at >= 0) set_side(b.upper_at + i, u - shift, -1.0);
    b.partial =
        b.partial || (b.lower_at >= 0 && l == -infinity) || (b.upper_at >= 0 && u == infinity);
  }
  if (!b.soft) return;
  for (const int first : {b.lower_at, b.upper_at})
    for (int i = 0; i < b.rows && first >= 0; ++i) {
      to.l1[first + i] = group->l1[b.source[i]];
      to.l2[first + i] = group->l2[b.source[i]];
    }
}

void Packing::fill_bounds(int k) {
  const Stage& s = qp.stages[k];
  const PackedStage& p = to.stages[k];
  const BoundBlock& b = p.bounds;
  const int n = p.sweep.nx + p.sweep.nu;
  for (int i = 0; i < b.length && b.first + i < n; ++i) {
    const int j = b.first + i + p.constant_states;
    if (lower_bound(s, j) == upper_bound(s, j)) continue;
    if (b.lower_at >= 0) set_side(b.lower_at + i, lower_bound(s, j), 1.0);
    if (b.upper_at >= 0) set_side(b.upper_at + i, upper_bound(s, j), -1.0);
  }
}

}  // namespace saltus::qp
