// Packing of a stage's rows: groups and bounds as blocks of rows with the same columns, equalities
// and inequalities apart. C of a further part is C T_p^-1.
#include <algorithm>
#include <cmath>

#include "saltus/qp/packing.hpp"

namespace saltus::qp {
namespace {

// The last fits any size.
constexpr RowKernel row_kernels[] = {row_kernel<1>(), row_kernel<2>(), row_kernel<3>(),
                                     row_kernel<4>(), row_kernel<6>(), row_kernel<-1>()};

// Which of the sides of some rows exist.
struct Sides {
  bool lower = false, upper = false;
  void see(double l, double u) {
    lower = lower || l != -infinity;
    upper = upper || u != infinity;
  }
};

bool crossed(double l, double u) { return std::isnan(l) || std::isnan(u) || l > u; }
bool without_sides(double l, double u) { return l == -infinity && u == infinity; }

}  // namespace

bool Packing::rows(int k) {
  const Stage& s = qp.stages[k];
  const int first = blocks;
  for (int g = 0; g < static_cast<int>(s.groups.size()) && ok; ++g) {
    if (s.groups[g].rows == 0) continue;
    add_group(k, g, false);
    if (!s.groups[g].soft) add_group(k, g, true);
  }
  if (ok) bounds(k);
  to.stages[k].rows = {to.storage.blocks.data() + first, static_cast<std::size_t>(blocks - first)};
  return ok;
}

// --- blocks -------------------------------------------------------------------------------------

RowBlock& Packing::new_block(int k, int group, int rows, int columns, int part) {
  RowBlock& b = to.storage.blocks[blocks++];
  const PackedStage& p = to.stages[k];
  b = RowBlock{};
  b.rows = rows;
  b.columns = columns;
  b.group = group;
  b.part = part;
  b.v_at = p.v_at + (part == 0 ? 0 : p.sweep.ld + (part - 1) * padded(p.sweep.nu));
  return b;
}

// Given columns and C: everything that follows from them; of the twin's, if there is one.
void Packing::finish_block(int k, RowBlock& b, const RowBlock* twin) {
  b.kernel = kernel_for(row_kernels, &RowKernel::columns, b.columns);
  b.contiguous = true;
  for (int c = 1; c < b.columns; ++c) b.contiguous = b.contiguous && b.column[c] == b.column[0] + c;
  const auto leading_dimension = [&](int stage) {
    const SweepStage& w = to.stages[stage].sweep;
    return b.part == 0 ? w.ld : padded(w.nu);
  };
  const int ld = leading_dimension(k);
  if (twin != nullptr) {
    b.C = twin->C;
    b.Ct = twin->Ct;
    b.pairs = twin->pairs;
    // The columns of twins differ by an offset at most.
    if (b.column[0] == twin->column[0] && ld == leading_dimension(k - 1)) b.target = twin->target;
  }
  if (b.target == nullptr) b.target = targets(b, ld);
  if (twin != nullptr || !ok) return;
  const int ld_rows = padded(b.rows), ld_columns = padded(b.columns);
  double* Ct = zeros(ld_columns * b.rows);
  if (!ok) return;
  for (int j = 0; j < b.columns; ++j)
    for (int i = 0; i < b.rows; ++i) Ct[j + i * ld_columns] = b.C[i + j * ld_rows];
  b.Ct = Ct;
  if (b.columns <= max_pair_columns) b.pairs = products_of_pairs(b);
}

// Offsets in a Hessian with leading dimension ld of all pairs of the block's columns.
int* Packing::targets(const RowBlock& b, int ld) {
  int* target = integers(pairs_of(b.columns));
  if (!ok) return nullptr;
  for (int j = 0, at = 0; j < b.columns; ++j)
    for (int i = 0; i <= j; ++i) target[at++] = b.column[i] + b.column[j] * ld;
  return target;
}

double* Packing::products_of_pairs(const RowBlock& b) {
  const int ld_columns = padded(b.columns), ld_pairs = padded(pairs_of(b.columns));
  double* pairs = numbers(ld_pairs * b.rows);
  if (!ok) return nullptr;
  for (int r = 0; r < b.rows; ++r) {
    const double* row = b.Ct + r * ld_columns;
    int at = r * ld_pairs;
    for (int j = 0; j < b.columns; ++j)
      for (int i = 0; i <= j; ++i) pairs[at++] = row[i] * row[j];
    while (at < (r + 1) * ld_pairs) pairs[at++] = 0.0;
  }
  return pairs;
}

// In y, or among the hard or soft sides.
void Packing::give_offsets(RowBlock& b, bool equalities, bool has_lower, bool has_upper) {
  const auto take = [&](int& count) {
    const int first = count;
    count += padded(b.rows);
    return first;
  };
  if (equalities) {
    to.has_equality_rows = true;
    b.equality_at = take(y);
    return;
  }
  int& sides = b.soft ? soft : hard;
  if (has_lower) b.lower_at = take(sides);
  if (has_upper) b.upper_at = take(sides);
}

// --- groups -------------------------------------------------------------------------------------

void Packing::add_group(int k, int g, bool equalities) {
  const Stage& s = qp.stages[k];
  const RowGroup& group = s.groups[g];
  const PackedStage& p = to.stages[k];
  const int all_columns = static_cast<int>(group.columns.size());
  if (group.rows > group.M.rows() || all_columns > group.M.cols()) {
    ok = false;
    return;
  }
  int* source = integers(group.rows);
  int* user_column = integers(all_columns);
  int* column = integers(std::max(all_columns, p.sweep.nu));
  if (!ok) return;
  int rows = 0;
  Sides sides;
  for (int i = 0; i < group.rows; ++i) {
    const double l = group.lower[i], u = group.upper[i];
    if (crossed(l, u)) {
      ok = false;
      return;
    }
    if ((l == u && !group.soft) != equalities || without_sides(l, u)) continue;
    if (p.constant_states > 0 && !group.soft && is_settled(k, g, i)) continue;
    source[rows++] = i;
    sides.see(l, u);
  }
  if (rows == 0) return;
  int own_columns = 0, part = 0;
  for (int c = 0; c < all_columns; ++c) {
    const Column at = column_of(k, group.columns[c]);
    if (at.part < 0) continue;
    part = at.part;
    column[own_columns] = at.offset;
    user_column[own_columns++] = c;
  }
  // Rows that touch the fixed start only cannot be influenced.
  if (own_columns == 0) return;
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
  if (!ok) return;
  b.C = C;
  finish_block(k, b, twin);
  give_offsets(b, equalities, sides.lower, sides.upper);
}

// The block of the stage before, if its coefficients are the same.
const RowBlock* Packing::twin_of(int k, const RowBlock& b) const {
  if (k == 0 || b.group >= static_cast<int>(qp.stages[k - 1].groups.size())) return nullptr;
  const RowGroup& group = qp.stages[k].groups[b.group];
  const RowGroup& other = qp.stages[k - 1].groups[b.group];
  const int columns = static_cast<int>(group.columns.size());
  if (other.rows != group.rows || other.columns.size() != group.columns.size()) return nullptr;
  if (b.part > 0 && to.stages[k - 1].T != to.stages[k].T) return nullptr;
  // Offsets in the stage vector may differ (a fixed start has no states), their order may not.
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

// C, from those columns of the group that are variables.
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

// To a largest coefficient of 1: the weight on equality rows is the same for all.
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

// A hard row of the fixed start alone: it holds or it contradicts.
bool Packing::is_settled(int k, int g, int row) {
  const Stage& s = qp.stages[k];
  const RowGroup& group = s.groups[g];
  const double l = group.lower[row], u = group.upper[row];
  double free = 0.0, value = 0.0, size = 0.0;
  for (int c = 0; c < static_cast<int>(group.columns.size()); ++c) {
    const int j = group.columns[c];
    const double m = group.M(row, c);
    size = std::max(size, std::fabs(m));
    if (j >= s.nx)
      free = std::max(free, std::fabs(m));
    else
      value += m * qp.start[j];
  }
  if (std::isfinite(l)) size = std::max(size, std::fabs(l));
  if (std::isfinite(u)) size = std::max(size, std::fabs(u));
  // Of what is left after the arithmetic that made the rows.
  constexpr double rounding = 1e-13, agreement = 1e-9;
  if (free > (l == u ? rounding * size : 0.0)) return false;
  const double missing = std::max(l - value, value - u);
  if (missing > agreement * std::max(1.0, size)) to.contradiction = true;
  return true;
}

// --- bounds -------------------------------------------------------------------------------------

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
