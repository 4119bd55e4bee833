// Packing of numbers per side and equality row, once every offset is known: beta, which sides there
// are, penalties, right-hand sides. What a fixed start contributes to a row moves to its side.
#include <algorithm>
#include <cmath>

#include "saltus/qp/packing.hpp"

namespace saltus::qp {

void Packing::fill_sides() {
  std::fill_n(to.active.data(), to.sides, 0.0);
  std::fill_n(to.beta.data(), to.sides, 0.0);
  std::fill_n(to.wanted.data(), to.equalities, 0.0);
  std::fill_n(to.l1.data() + to.first_soft, soft, 1.0);
  std::fill_n(to.l2.data() + to.first_soft, soft, 0.0);
  for (int k = 0; k < static_cast<int>(qp.stages.size()); ++k) {
    for (RowBlock& b : to.stages[k].rows)
      for (int i = 0; i < b.rows; ++i) fill_row(k, b, i);
    fill_bounds(k);
  }
}

void Packing::set_side(int side, double value, double sign) {
  if (!std::isfinite(value)) return;
  to.active[side] = 1.0;
  to.beta[side] = sign * value;
}

void Packing::fill_row(int k, RowBlock& b, int i) {
  const Stage& s = qp.stages[k];
  const int from = b.source[i];
  double shift = 0.0, l, u;
  if (b.group >= 0) {
    const RowGroup& group = s.groups[b.group];
    for (int c = 0; starts_fixed(k) && c < static_cast<int>(group.columns.size()); ++c)
      if (group.columns[c] < s.nx) shift += group.M(from, c) * qp.start[group.columns[c]];
    l = group.lower[from];
    u = group.upper[from];
  } else {
    l = lower_bound(s, from);
    u = upper_bound(s, from);
  }
  if (b.equality_at >= 0) {
    to.wanted[b.equality_at + i] = (l - shift) * b.scale[i];
    return;
  }
  b.partial =
      b.partial || (b.lower_at >= 0 && l == -infinity) || (b.upper_at >= 0 && u == infinity);
  if (b.lower_at >= 0) set_side(b.lower_at + i, l - shift, 1.0);
  if (b.upper_at >= 0) set_side(b.upper_at + i, u - shift, -1.0);
  if (!b.soft) return;
  const RowGroup& group = s.groups[b.group];
  for (const int first : {b.lower_at, b.upper_at})
    if (first >= 0) {
      to.l1[first + i] = group.l1[from];
      to.l2[first + i] = group.l2[from];
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
