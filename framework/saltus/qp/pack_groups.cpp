// Packing of row groups: selects the active rows, separates equalities from inequalities, and packs
// their coefficients. C of a further part is C T_p^-1.
#include <algorithm>
#include <cmath>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/packing.hpp"

namespace saltus::qp {

// Adds the equalities or the inequalities of a group. Returns true if the group also has rows of
// the other kind.
bool Packing::add_group(int k, int g, bool equalities) {
  const Stage& s = qp.stages[k];
  const RowGroup& group = s.groups[g];
  const PackedStage& p = to.stages[k];
  const int all_columns = static_cast<int>(group.columns.size());
  if (group.rows > group.M.rows() || all_columns > group.M.cols()) {
    ok = false;
    return false;
  }
  int* source = integers(group.rows);
  int* user_column = integers(all_columns);
  int* column = integers(std::max(all_columns, p.sweep.nu));
  if (!ok) return false;
  int rows = 0;
  bool others = false;
  Sides sides;
  for (int i = 0; i < group.rows; ++i) {
    const double l = group.lower[i], u = group.upper[i];
    if (crossed(l, u)) {
      ok = false;
      return false;
    }
    if (without_sides(l, u)) continue;
    if ((l == u && !group.soft) != equalities) {
      others = true;
      continue;
    }
    if (p.constant_states > 0 && !group.soft && depends_on_start_only(k, g, i)) continue;
    source[rows++] = i;
    sides.see(l, u);
  }
  if (rows == 0) return others;
  int own_columns = 0, part = 0;
  for (int c = 0; c < all_columns; ++c) {
    const Column at = column_of(k, group.columns[c]);
    if (at.part < 0) continue;
    part = at.part;
    column[own_columns] = at.offset;
    user_column[own_columns++] = c;
  }
  // Rows that depend only on the fixed start cannot be influenced; rows without columns are zero.
  if (own_columns == 0) {
    for (int i = 0; i < rows && all_columns == 0 && !group.soft; ++i) {
      const Bounds b{group.lower[source[i]], group.upper[source[i]]};
      if (violation_in_tolerances(b, 0.0) > 1.0) to.contradiction = true;
    }
    return others;
  }
  const int columns = part > 0 ? p.sweep.nu : own_columns;
  if (part > 0)
    for (int c = 0; c < columns; ++c) column[c] = c;
  RowBlock& b = new_block(k, g, rows, columns, part);
  b.column = column;
  b.source = source;
  b.soft = group.soft;
  const bool may_have_twin = !equalities && (part > 0 || own_columns == all_columns);
  const RowBlock* twin = may_have_twin ? twin_of(k, b) : nullptr;
  double* C = twin == nullptr ? coefficients(k, b, user_column, own_columns) : nullptr;
  if (equalities && ok) scale_rows(b, C);
  if (!ok) return false;
  b.C = C;
  if (C != nullptr && !equalities && part == 0) keep_single_entries(b, C, column);
  finish_block(k, b, twin);
  give_offsets(b, equalities, sides.lower, sides.upper);
  return others;
}

// The only block of this group if it contains inequalities, otherwise null.
const RowBlock* Packing::only_block_of(int k, int g) const {
  const RowBlock* found = nullptr;
  for (const RowBlock& b : to.stages[k].rows) {
    if (b.group != g) continue;
    if (found != nullptr || b.equality_at >= 0) return nullptr;
    found = &b;
  }
  return found;
}

// If a group has the same data as in the previous stage, its block is a copy, except for the
// offsets in v and in the sides.
bool Packing::repeat_group(int k, int g) {
  // The fixed start changes the rows of the first stage only.
  if (k < 2 || g >= static_cast<int>(qp.stages[k - 1].groups.size())) return false;
  const Stage &s = qp.stages[k], &t = qp.stages[k - 1];
  const RowGroup &group = s.groups[g], &other = t.groups[g];
  const PackedStage &p = to.stages[k], &before = to.stages[k - 1];
  const int rows = group.rows, columns = static_cast<int>(group.columns.size());
  if (s.nx != t.nx || s.nu != t.nu || p.parts != before.parts || p.T != before.T) return false;
  if (other.rows != rows || other.columns != group.columns || other.soft != group.soft ||
      group.M.rows() < rows || group.M.cols() < columns || other.M.rows() < rows ||
      other.M.cols() < columns)
    return false;
  const RowBlock* twin = only_block_of(k - 1, g);
  if (twin == nullptr || !same(group.lower, other.lower, rows) ||
      !same(group.upper, other.upper, rows) || !same(group.M, other.M, rows, columns))
    return false;
  if (group.soft && !(same(group.l1, other.l1, rows) && same(group.l2, other.l2, rows)))
    return false;
  RowBlock& b = to.storage.blocks[blocks++];
  b = *twin;
  b.v_at += p.v_at - before.v_at;
  b.twin = twin;
  give_offsets(b, false, twin->lower_at >= 0, twin->upper_at >= 0);
  return true;
}

// The block of the previous stage if its coefficients are the same, otherwise null.
const RowBlock* Packing::twin_of(int k, const RowBlock& b) const {
  if (k == 0 || b.group >= static_cast<int>(qp.stages[k - 1].groups.size())) return nullptr;
  const RowGroup& group = qp.stages[k].groups[b.group];
  const RowGroup& other = qp.stages[k - 1].groups[b.group];
  const int columns = static_cast<int>(group.columns.size());
  if (other.rows != group.rows || other.columns.size() != group.columns.size()) return nullptr;
  if (b.part > 0 && to.stages[k - 1].T != to.stages[k].T) return nullptr;
  // Offsets in the stage vector may differ (a fixed start has no states), but not their order.
  const int nx = qp.stages[k].nx, shift = group.columns[0] - other.columns[0];
  if (shift != (group.columns[0] >= nx ? nx - qp.stages[k - 1].nx : 0)) return nullptr;
  for (int c = 1; c < columns; ++c)
    if (group.columns[c] - other.columns[c] != shift) return nullptr;
  for (const RowBlock& t : to.stages[k - 1].rows)
    if (t.group == b.group && t.equality_at < 0 && t.rows == b.rows && t.columns == b.columns &&
        t.part == b.part && std::equal(b.source, b.source + b.rows, t.source))
      return same(group.M, other.M, group.rows, columns) ? &t : nullptr;
  return nullptr;
}

// Computes C from the columns of the group that are variables.
double* Packing::coefficients(int k, const RowBlock& b, const int* user_column, int user_columns) {
  const Stage& s = qp.stages[k];
  const RowGroup& group = s.groups[b.group];
  const PackedStage& p = to.stages[k];
  const int ld = padded(b.rows);
  double* C = zeros(ld * b.columns);
  if (!ok) return nullptr;
  if (b.part == 0) {
    for (int c = 0; c < b.columns; ++c)
      for (int i = 0; i < b.rows; ++i) C[i + c * ld] = group.M(b.source[i], user_column[c]);
    return C;
  }
  const int m = p.sweep.nu, ldm = padded(m);
  for (int c = 0; c < user_columns; ++c) {
    const int local = group.columns[user_column[c]] - s.nx - b.part * m;
    for (int j = 0; j < m; ++j) {
      const double t = p.T_inverse[local + ((b.part - 1) * m + j) * ldm];
      for (int i = 0; i < b.rows; ++i) C[i + j * ld] += group.M(b.source[i], user_column[c]) * t;
    }
  }
  return C;
}

// If every row has one entry, in ascending columns, only these entries are stored.
void Packing::keep_single_entries(RowBlock& b, double* C, int* column) {
  const int ld = padded(b.rows);
  // The column of the only entry of a row, or -1.
  const auto only = [&](int row) {
    int found = -1;
    for (int c = 0; c < b.columns; ++c) {
      if (C[row + c * ld] == 0.0) continue;
      if (found >= 0) return -1;
      found = c;
    }
    return found;
  };
  for (int i = 0, last = -1; i < b.rows; ++i) {
    const int c = only(i);
    if (c <= last) return;
    last = c;
  }
  for (int i = 0; i < b.rows; ++i) {
    const int c = only(i);
    C[i] = C[i + c * ld];
    column[i] = column[c];
  }
  b.columns = b.rows;
  b.diagonal = true;
}

// Scales the largest coefficient of every row to 1: all equality rows have the same weight.
void Packing::scale_rows(RowBlock& b, double* C) {
  const int ld = padded(b.rows);
  double* scale = numbers(b.rows);
  if (!ok) return;
  for (int i = 0; i < b.rows; ++i) {
    double most = 0.0;
    for (int c = 0; c < b.columns; ++c) most = std::max(most, std::fabs(C[i + c * ld]));
    scale[i] = most > 0.0 ? 1.0 / most : 1.0;
    for (int c = 0; c < b.columns; ++c) C[i + c * ld] *= scale[i];
  }
  b.scale = scale;
}

// True if a hard row depends only on the fixed start. If it is violated, sets `contradiction`.
bool Packing::depends_on_start_only(int k, int g, int row) {
  const Stage& s = qp.stages[k];
  const RowGroup& group = s.groups[g];
  const double l = group.lower[row], u = group.upper[row];
  double free = 0.0, value = 0.0, size = 0.0;
  for (int c = 0; c < static_cast<int>(group.columns.size()); ++c) {
    const int j = group.columns[c];
    const double m = group.M(row, c);
    if (j >= s.nx && m != 0.0 && l != u) return false;
    size = std::max(size, std::fabs(m));
    if (j >= s.nx)
      free = std::max(free, std::fabs(m));
    else
      value += m * qp.start[j];
  }
  if (std::isfinite(l)) size = std::max(size, std::fabs(l));
  if (std::isfinite(u)) size = std::max(size, std::fabs(u));
  // Rounding error of the arithmetic that produced the rows.
  constexpr double rounding = 1e-13;
  if (free > (l == u ? rounding * size : 0.0)) return false;
  if (violation_in_tolerances({l, u}, value) > 1.0) to.contradiction = true;
  return true;
}

}  // namespace saltus::qp
