// Packing of a stage's rows as blocks of rows with the same columns: the data derived from the
// columns and coefficients of a block. pack_groups.cpp and pack_bounds.cpp select the rows.

#include "saltus/qp/packing.hpp"

namespace saltus::qp {
namespace {

// The last kernel fits every size.
constexpr RowKernel row_kernels[] = {row_kernel<1>(), row_kernel<2>(), row_kernel<3>(),
                                     row_kernel<4>(), row_kernel<6>(), row_kernel<-1>()};

}  // namespace

bool Packing::rows(int k) {
  const Stage& s = qp.stages[k];
  const int first = blocks;
  for (int g = 0; g < static_cast<int>(s.groups.size()) && ok; ++g) {
    if (s.groups[g].rows == 0 || repeat_group(k, g)) continue;
    if (add_group(k, g, false)) add_group(k, g, true);
  }
  if (ok) bounds(k);
  to.stages[k].rows = {to.storage.blocks.data() + first, static_cast<std::size_t>(blocks - first)};
  return ok;
}

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

// Computes all data derived from the columns and C, or copies them from the twin.
void Packing::finish_block(int k, RowBlock& b, const RowBlock* twin) {
  if (twin != nullptr) b.diagonal = twin->diagonal;
  b.kernel =
      b.diagonal ? &diagonal_row_kernel : kernel_for(row_kernels, &RowKernel::columns, b.columns);
  b.contiguous = true;
  for (int c = 1; c < b.columns; ++c) b.contiguous = b.contiguous && b.column[c] == b.column[0] + c;
  const SweepStage& w = to.stages[k].sweep;
  const bool on_inputs = b.part > 0 || b.column[0] >= w.nx;
  b.joined = to.stages[k].parts > 1 && on_inputs ? b.part : -1;
  const int ld = b.joined < 0 ? w.ld : padded(w.nu);
  if (twin != nullptr) {
    b.C = twin->C;
    b.Ct = twin->Ct;
    b.pairs = twin->pairs;
    // Columns of twins differ at most by an offset.
    const SweepStage& before = to.stages[k - 1].sweep;
    if (b.column[0] == twin->column[0] && b.joined == twin->joined && w.nx == before.nx &&
        w.nu == before.nu)
      b.target = twin->target;
  }
  const int first = b.joined == 0 ? w.nx : 0;
  if (b.target == nullptr) b.target = targets(b, first, ld);
  if (twin != nullptr || b.diagonal || !ok) return;
  const int ld_rows = padded(b.rows), ld_columns = padded(b.columns);
  double* Ct = zeros(ld_columns * b.rows);
  if (!ok) return;
  for (int j = 0; j < b.columns; ++j)
    for (int i = 0; i < b.rows; ++i) Ct[j + i * ld_columns] = b.C[i + j * ld_rows];
  b.Ct = Ct;
  if (b.columns <= max_pair_columns) b.pairs = products_of_pairs(b);
}

// Offsets of all pairs of the block's columns in a Hessian of the variables from `first` on with
// leading dimension ld.
int* Packing::targets(const RowBlock& b, int first, int ld) {
  int* target = integers(b.diagonal ? b.columns : pairs_of(b.columns));
  if (!ok) return nullptr;
  for (int j = 0, at = 0; j < b.columns; ++j)
    for (int i = b.diagonal ? j : 0; i <= j; ++i)
      target[at++] = b.column[i] - first + (b.column[j] - first) * ld;
  return target;
}

double* Packing::products_of_pairs(const RowBlock& b) {
  const int ld_columns = padded(b.columns), ld_pairs = padded_pairs_of(b.columns);
  double* pairs = numbers(ld_pairs * b.rows);
  if (!ok) return nullptr;
  for (int r = 0; r < b.rows; ++r) {
    const double* row = b.Ct + r * ld_columns;
    int at = r * ld_pairs;
    for (int j = 0; j < b.columns; at += padded(++j)) {
      for (int i = 0; i <= j; i += lanes) store(pairs + at + i, load(row + i) * row[j]);
      for (int i = j + 1; i < padded(j + 1); ++i) pairs[at + i] = 0.0;
    }
  }
  return pairs;
}

// Assigns offsets in y, or among the hard or soft sides.
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

}  // namespace saltus::qp
