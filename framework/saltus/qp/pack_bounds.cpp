// Packing of bounds. Bounds of variables of v are stored side by side. Equal bounds become rows,
// and so do bounds of inputs that enter v as their contribution to a resultant.
#include <algorithm>

#include "saltus/qp/packing.hpp"

namespace saltus::qp {

// True if no entry is bounded.
bool Packing::without_bounds(int k) const {
  const Stage& s = qp.stages[k];
  const auto open = [](const VectorXd& lower, const VectorXd& upper, int size) {
    bool all = true;
    for (int i = 0; i < size; ++i) all = all && lower[i] == -infinity && upper[i] == infinity;
    return all;
  };
  return open(s.x_lower, s.x_upper, s.nx) && open(s.u_lower, s.u_upper, s.nu);
}

void Packing::bounds(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = to.stages[k];
  const int entries = s.nx + s.nu;
  p.bounds = BoundBlock{};
  if (without_bounds(k)) return;
  int first = entries, last = -1, equal = 0;
  Sides sides;
  int further[max_parts] = {};  // number of bounded inputs per part after the first
  for (int j = p.constant_states; j < entries; ++j) {
    const double l = lower_bound(s, j), u = upper_bound(s, j);
    if (crossed(l, u)) {
      ok = false;
      return;
    }
    if (without_sides(l, u)) continue;
    const Column at = column_of(k, j);
    if (at.part > 0) {
      ++further[at.part];
    } else if (l == u) {
      ++equal;
    } else {
      first = std::min(first, at.offset);
      last = std::max(last, at.offset);
      sides.see(l, u);
    }
  }
  if (last >= first) {
    p.bounds.first = first / lanes * lanes;
    p.bounds.length = padded(last + 1) - p.bounds.first;
    if (sides.lower) p.bounds.lower_at = hard;
    if (sides.lower) hard += p.bounds.length;
    if (sides.upper) p.bounds.upper_at = hard;
    if (sides.upper) hard += p.bounds.length;
  }
  if (equal > 0 && p.parts == 1) add_bound_rows(k, 0, true, 0, entries);
  if (equal > 0 && p.parts > 1) {
    // With several parts, the inputs have a separate Hessian.
    add_bound_rows(k, 0, true, 0, s.nx);
    if (ok) add_bound_rows(k, 0, true, s.nx, entries);
  }
  for (int part = 1; part < p.parts && ok; ++part) {
    if (further[part] == 0) continue;
    add_bound_rows(k, part, false, s.nx, entries);
    if (ok) add_bound_rows(k, part, true, s.nx, entries);
  }
}

// Adds bounds of these entries as rows: equal bounds, and bounds of inputs that enter v as their
// contribution to a resultant.
void Packing::add_bound_rows(int k, int part, bool equalities, int begin, int end) {
  const Stage& s = qp.stages[k];
  const PackedStage& p = to.stages[k];
  const int m = p.sweep.nu, ldm = padded(m);
  int* source = integers(end - begin);
  int* column = integers(std::max(end - begin, m));
  if (!ok) return;
  int rows = 0;
  Sides sides;
  for (int j = std::max(p.constant_states, begin); j < end; ++j) {
    const double l = lower_bound(s, j), u = upper_bound(s, j);
    const Column at = column_of(k, j);
    if (at.part != part || without_sides(l, u) || (l == u) != equalities) continue;
    column[rows] = at.offset;
    source[rows++] = j;
    sides.see(l, u);
  }
  if (rows == 0) return;
  const int columns = part > 0 ? m : rows;
  if (part > 0)
    for (int c = 0; c < columns; ++c) column[c] = c;
  RowBlock& b = new_block(k, -1, rows, columns, part);
  const int ld = padded(rows);
  double* C = zeros(ld * columns);
  double* scale = numbers(rows);
  if (!ok) return;
  std::fill(scale, scale + rows, 1.0);
  for (int i = 0; i < rows; ++i)
    if (part == 0)
      C[i + i * ld] = 1.0;
    else
      for (int c = 0; c < m; ++c)
        C[i + c * ld] = p.T_inverse[source[i] - s.nx - part * m + ((part - 1) * m + c) * ldm];
  b.C = C;
  b.scale = scale;
  b.column = column;
  b.source = source;
  finish_block(k, b, nullptr);
  give_offsets(b, equalities, sides.lower, sides.upper);
}

}  // namespace saltus::qp
