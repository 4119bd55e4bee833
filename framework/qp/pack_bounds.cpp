// Packing of bounds: where an entry of v is a variable they stand side by side; equal ones, and
// those of inputs that stand in v as what they add to a resultant, become rows.
#include <algorithm>

#include "saltus/qp/packing.hpp"

namespace saltus::qp {

void Packing::bounds(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = to.stages[k];
  const int entries = s.nx + s.nu;
  int first = entries, last = -1, equal = 0;
  Sides sides;
  int further[max_parts] = {};  // bounded inputs per further part
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
  p.bounds = BoundBlock{};
  if (last >= first) {
    p.bounds.first = first / lanes * lanes;
    p.bounds.length = padded(last + 1) - p.bounds.first;
    if (sides.lower) p.bounds.lower_at = hard;
    if (sides.lower) hard += p.bounds.length;
    if (sides.upper) p.bounds.upper_at = hard;
    if (sides.upper) hard += p.bounds.length;
  }
  if (equal > 0) add_bound_rows(k, 0, true);
  for (int part = 1; part < p.parts && ok; ++part) {
    if (further[part] == 0) continue;
    add_bound_rows(k, part, false);
    if (ok) add_bound_rows(k, part, true);
  }
}

// Bounds as rows: equal ones, and those of inputs that stand in v as what they add to a resultant.
void Packing::add_bound_rows(int k, int part, bool equalities) {
  const Stage& s = qp.stages[k];
  const PackedStage& p = to.stages[k];
  const int entries = s.nx + s.nu, m = p.sweep.nu, ldm = padded(m);
  int* source = integers(entries);
  int* column = integers(entries);
  if (!ok) return;
  int rows = 0;
  Sides sides;
  for (int j = p.constant_states; j < entries; ++j) {
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
