#include "saltus/qp/riccati_packer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "saltus/qp/resultant.hpp"

namespace saltus::qp {
namespace {

bool same(const MatrixXd& a, const MatrixXd& b, int rows, int columns) {
  for (int j = 0; j < columns; ++j)
    if (std::memcmp(&a.coeffRef(0, j), &b.coeffRef(0, j), sizeof(double) * rows) != 0) return false;
  return true;
}

bool is_zero(const MatrixXd& a, int row, int column, int rows, int columns) {
  for (int j = column; j < column + columns; ++j)
    for (int i = row; i < row + rows; ++i)
      if (a(i, j) != 0.0) return false;
  return true;
}

// Bounds of entry j of v = (x, u).
double lower_bound(const Stage& s, int j) { return j < s.nx ? s.x_lower[j] : s.u_lower[j - s.nx]; }
double upper_bound(const Stage& s, int j) { return j < s.nx ? s.x_upper[j] : s.u_upper[j - s.nx]; }

constexpr RiccatiKernel any_size = riccati_kernel<-1, -1, -1>();

// The last fits any size.
constexpr RowKernel row_kernels[] = {row_kernel<1>(), row_kernel<2>(), row_kernel<3>(),
                                     row_kernel<4>(), row_kernel<6>(), row_kernel<-1>()};
constexpr SplitKernel split_kernels[] = {split_kernel<3>(), split_kernel<6>(), split_kernel<-1>()};

template <class Kernel, std::size_t count>
const Kernel* kernel_for(const Kernel (&kernels)[count], int Kernel::*size, int wanted) {
  for (const Kernel& k : kernels)
    if (k.*size == wanted) return &k;
  return &kernels[count - 1];
}

}  // namespace

bool RiccatiSystem::Packer::run() {
  system.numbers_.reset();
  system.integers_.reset();
  system.has_equality_rows_ = false;
  system.contradiction_ = false;
  system.reduced_stages_ = 0;
  const int stages = static_cast<int>(qp.stages.size());
  if (stages != static_cast<int>(system.stages_.size())) return false;
  // Constraints of all stages come one after the other: dynamics first in y.
  for (int k = 0; k < stages && ok; ++k) stage(k);
  if (!ok) return false;
  for (int k = 0; k < stages && ok; ++k) {
    const int first = blocks;
    groups(k);
    bounds(k);
    system.stages_[k].rows = {system.blocks_.data() + first,
                              static_cast<std::size_t>(blocks - first)};
  }
  if (!ok) return false;
  system.first_soft_ = hard;
  for (int i = 0; i < blocks; ++i) {
    RowBlock& b = system.blocks_[i];
    if (!b.soft) continue;
    if (b.lower_at >= 0) b.lower_at += hard;
    if (b.upper_at >= 0) b.upper_at += hard;
  }
  system.variables_ = v;
  system.equalities_ = y;
  system.sides_ = hard + soft;
  return v <= system.max_variables_ && y <= system.max_equalities_ &&
         system.sides_ <= system.max_sides_;
}

void RiccatiSystem::Packer::stage(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = system.stages_[k];
  const bool last = k == qp.intervals();
  if (s.nx > s.q.size() || s.nu > s.r.size()) {
    ok = false;
    return;
  }
  p.constant_states = starts_fixed(k) ? s.nx : 0;
  p.free_states = starts_free(k) ? s.nx : 0;
  p.sweep.nx = k == 0 ? 0 : s.nx;
  p.sweep.next = last ? 0 : qp.stages[k + 1].nx;
  choose_parts(k);
  p.sweep.nu = p.free_states + s.nu / p.parts;
  SweepStage& w = p.sweep;
  const int n = w.nx + w.nu;
  w.ld = padded(n);
  w.ld_next = padded(w.next);
  p.kernel = &any_size;
  for (const RiccatiKernel& kernel : system.kernels_)
    if (kernel.nx == w.nx && kernel.nu == w.nu && kernel.next == w.next) p.kernel = &kernel;
  w.M = numbers(w.ld * n);
  w.L = numbers(w.ld * w.nu);
  w.pivot = numbers(padded(w.nu));
  w.p = numbers(w.ld);
  p.v_at = v;
  v += w.ld + (p.parts - 1) * padded(w.nu);
  p.costate_at = y;
  y += w.ld_next;
  if (!ok) return;
  flow(k);
  cost(k);
}

bool RiccatiSystem::Packer::columns_fit_parts(const Stage& s, int size) const {
  for (const RowGroup& g : s.groups) {
    if (g.rows == 0 || g.columns.empty()) continue;
    int part = -2;
    for (const int j : g.columns) {
      const int here = j < s.nx ? -1 : (j - s.nx) / size;
      if (part == -2) part = here;
      if (part != here) return false;
    }
  }
  return true;
}

void RiccatiSystem::Packer::choose_parts(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = system.stages_[k];
  p.parts = 1;
  const int size = s.resultant_size;
  if (size <= 0 || starts_free(k) || k == qp.intervals() || s.nu % size != 0) return;
  const int parts = s.nu / size;
  if (parts < 2 || parts > max_parts || p.sweep.next < size) return;
  // They share neither cost nor rows.
  if (!is_zero(s.S, 0, 0, s.nu, s.nx) || !columns_fit_parts(s, size)) return;
  for (int part = 0; part + 1 < parts; ++part)
    if (!is_zero(s.R, (part + 1) * size, part * size, s.nu - (part + 1) * size, size)) return;
  if (!resultant_maps(k, parts)) return;
  p.parts = parts;
  p.split_kernel = kernel_for(split_kernels, &SplitKernel::size, size);
  ++system.reduced_stages_;
}

// T_p with B_p = B_1 T_p: those of the stage before if they serve.
bool RiccatiSystem::Packer::resultant_maps(int k, int parts) {
  const Stage& s = qp.stages[k];
  PackedStage& p = system.stages_[k];
  const ResultantSizes sizes{p.sweep.next, s.resultant_size, parts};
  if (k > 0) {
    const PackedStage& before = system.stages_[k - 1];
    if (before.parts == parts && before.sweep.nu == sizes.size &&
        (same(qp.stages[k - 1].B, s.B, sizes.rows, s.nu) ||
         maps_to_resultant(s.B, sizes, before.T))) {
      p.T = before.T;
      p.T_inverse = before.T_inverse;
      return true;
    }
  }
  const int count = padded(sizes.size) * (parts - 1) * sizes.size;
  double* T = numbers(count);
  double* inverse = numbers(count);
  if (!ok || !find_resultant_maps(s.B, sizes, T, inverse)) return false;
  p.T = T;
  p.T_inverse = inverse;
  return true;
}

void RiccatiSystem::Packer::flow(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = system.stages_[k];
  SweepStage& w = p.sweep;
  const int n = w.nx + w.nu, nn = w.next, states = k == 0 ? p.free_states : w.nx;
  if (nn > s.b.size()) {
    ok = false;
    return;
  }
  double* b = numbers(w.ld_next);
  if (!ok) return;
  std::fill(b, b + w.ld_next, 0.0);
  for (int i = 0; i < nn; ++i) b[i] = s.b[i];
  for (int j = 0; j < p.constant_states; ++j)
    for (int i = 0; i < nn; ++i) b[i] += s.A(i, j) * qp.start[j];
  p.b = b;
  if (k > 1) {
    const PackedStage& before = system.stages_[k - 1];
    const Stage& t = qp.stages[k - 1];
    if (before.sweep.nx == w.nx && before.sweep.nu == w.nu && before.sweep.next == nn &&
        same(s.A, t.A, nn, s.nx) && same(s.B, t.B, nn, w.nu)) {
      w.flow = before.sweep.flow;
      w.flow_transposed = before.sweep.flow_transposed;
      return;
    }
  }
  double* F = numbers(w.ld_next * n);
  double* Ft = numbers(w.ld * nn);
  if (!ok) return;
  std::fill(F, F + w.ld_next * n, 0.0);
  std::fill(Ft, Ft + w.ld * nn, 0.0);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < nn; ++i)
      Ft[j + i * w.ld] = F[i + j * w.ld_next] = j < states ? s.A(i, j) : s.B(i, j - states);
  w.flow = F;
  w.flow_transposed = Ft;
}

void RiccatiSystem::Packer::cost(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = system.stages_[k];
  const SweepStage& w = p.sweep;
  const int n = w.nx + w.nu, states = k == 0 ? p.free_states : w.nx, inputs = n - states;
  const int m = inputs, ld = padded(m);
  double* g = numbers(w.ld);
  double* r = p.parts > 1 ? numbers((p.parts - 1) * ld) : nullptr;
  if (!ok) return;
  std::fill(g, g + w.ld, 0.0);
  for (int j = 0; j < n; ++j) g[j] = j < states ? s.q[j] : s.r[j - states];
  for (int j = 0; j < p.constant_states; ++j)
    for (int i = 0; i < inputs; ++i) g[i] += s.S(i, j) * qp.start[j];
  if (r != nullptr) {
    std::fill(r, r + (p.parts - 1) * ld, 0.0);
    for (int c = 0; c < (p.parts - 1) * m; ++c) {
      const double* column = p.T_inverse + c * ld;
      const int part = c / m;
      double sum = 0.0;
      for (int i = 0; i < m; ++i) sum += column[i] * s.r[(part + 1) * m + i];
      r[part * ld + c % m] = sum;
    }
  }
  p.g = g;
  p.r = r;
  double* R_work = p.parts > 1 ? numbers((p.parts - 1) * ld * m) : nullptr;
  if (!ok) return;
  p.R_work = R_work;
  p.splits = system.splits_.data() + (max_parts - 1) * k;
  for (int part = 1; part < p.parts; ++part) {
    Split& split = p.splits[part - 1];
    split.before = numbers(Split::size(m));
    if (!ok) return;
    split.second = R_work + (part - 1) * ld * m;
    split.L = split.before + ld * m;
    split.Lt = split.L + ld * m;
    split.pivot = split.Lt + ld * m;
    split.difference = split.pivot + ld;
  }
  if (k > 1) {
    const PackedStage& before = system.stages_[k - 1];
    const Stage& t = qp.stages[k - 1];
    if (before.sweep.nx == w.nx && before.sweep.nu == w.nu && before.parts == p.parts &&
        (p.parts == 1 || before.T == p.T) && same(s.Q, t.Q, s.nx, s.nx) &&
        same(s.R, t.R, s.nu, s.nu) && same(s.S, t.S, s.nu, s.nx)) {
      p.H = before.H;
      p.R = before.R;
      return;
    }
  }
  double* H = numbers(w.ld * n);
  if (!ok) return;
  std::fill(H, H + w.ld * n, 0.0);
  for (int j = 0; j < states; ++j) {
    for (int i = 0; i < states; ++i) H[i + j * w.ld] = s.Q(i, j);
    if (p.parts == 1)
      for (int i = 0; i < inputs; ++i)
        H[states + i + j * w.ld] = H[j + (states + i) * w.ld] = s.S(i, j);
  }
  for (int j = 0; j < inputs; ++j)
    for (int i = 0; i < inputs; ++i) H[states + i + (states + j) * w.ld] = s.R(i, j);
  p.H = H;
  if (p.parts == 1) return;
  double* R = numbers((p.parts - 1) * ld * m);
  if (!ok) return;
  std::fill(R, R + (p.parts - 1) * ld * m, 0.0);
  for (int part = 0; part + 1 < p.parts; ++part)
    for (int c = 0; c < m; ++c) {
      const double* right = p.T_inverse + (part * m + c) * ld;
      double* half = system.work_.data();
      for (int i = 0; i < m; ++i) {
        half[i] = 0.0;
        for (int l = 0; l < m; ++l)
          half[i] += s.R((part + 1) * m + i, (part + 1) * m + l) * right[l];
      }
      for (int i = 0; i < m; ++i) {
        const double* left = p.T_inverse + (part * m + i) * ld;
        double sum = 0.0;
        for (int l = 0; l < m; ++l) sum += left[l] * half[l];
        R[part * ld * m + i + c * ld] = sum;
      }
    }
  p.R = R;
}

RowBlock& RiccatiSystem::Packer::new_block(int k, int group, int rows, int columns, int part) {
  RowBlock& b = system.blocks_[blocks++];
  const PackedStage& p = system.stages_[k];
  b = RowBlock{};
  b.rows = rows;
  b.columns = columns;
  b.group = group;
  b.part = part;
  b.v_at = p.v_at + (part == 0 ? 0 : p.sweep.ld + (part - 1) * padded(p.sweep.nu));
  return b;
}

// Places of a block's rows: in y, or among the hard or soft sides.
void RiccatiSystem::Packer::place_rows(RowBlock& b, bool equalities, bool has_lower,
                                       bool has_upper) {
  if (equalities) {
    system.has_equality_rows_ = true;
    b.equality_at = y;
    y += padded(b.rows);
    return;
  }
  int& count = b.soft ? soft : hard;
  if (has_lower) {
    b.lower_at = count;
    count += padded(b.rows);
  }
  if (has_upper) {
    b.upper_at = count;
    count += padded(b.rows);
  }
}

// Given columns and C: everything that follows from them.
void RiccatiSystem::Packer::finish_block(int k, RowBlock& b, const RowBlock* twin) {
  const PackedStage& p = system.stages_[k];
  const int ld = b.part == 0 ? p.sweep.ld : padded(p.sweep.nu);
  int* target = integers(pairs_of(b.columns));
  if (!ok) return;
  b.kernel = kernel_for(row_kernels, &RowKernel::columns, b.columns);
  b.contiguous = true;
  for (int c = 1; c < b.columns; ++c) b.contiguous = b.contiguous && b.column[c] == b.column[0] + c;
  for (int j = 0, at = 0; j < b.columns; ++j)
    for (int i = 0; i <= j; ++i) target[at++] = b.column[i] + b.column[j] * ld;
  b.target = target;
  if (twin != nullptr) {
    b.C = twin->C;
    b.Ct = twin->Ct;
    b.pairs = twin->pairs;
    return;
  }
  const int ld_rows = padded(b.rows), ld_columns = padded(b.columns);
  double* Ct = numbers(ld_columns * b.rows);
  if (!ok) return;
  std::fill(Ct, Ct + ld_columns * b.rows, 0.0);
  for (int j = 0; j < b.columns; ++j)
    for (int i = 0; i < b.rows; ++i) Ct[j + i * ld_columns] = b.C[i + j * ld_rows];
  b.Ct = Ct;
  if (b.columns > max_pair_columns) return;
  const int ld_pairs = padded(pairs_of(b.columns));
  double* pairs = numbers(ld_pairs * b.rows);
  if (!ok) return;
  for (int r = 0; r < b.rows; ++r) {
    int at = r * ld_pairs;
    for (int j = 0; j < b.columns; ++j)
      for (int i = 0; i <= j; ++i) pairs[at++] = Ct[i + r * ld_columns] * Ct[j + r * ld_columns];
    while (at < (r + 1) * ld_pairs) pairs[at++] = 0.0;
  }
  b.pairs = pairs;
}

void RiccatiSystem::Packer::groups(int k) {
  for (int g = 0; g < static_cast<int>(qp.stages[k].groups.size()) && ok; ++g) {
    if (qp.stages[k].groups[g].rows == 0) continue;
    add_group(k, g, false);
    if (!qp.stages[k].groups[g].soft) add_group(k, g, true);
  }
}

// A hard row of the fixed start alone: it holds or it contradicts.
bool RiccatiSystem::Packer::is_settled(int k, int g, int row) {
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
  if (missing > agreement * std::max(1.0, size)) system.contradiction_ = true;
  return true;
}

void RiccatiSystem::Packer::add_group(int k, int g, bool equalities) {
  const Stage& s = qp.stages[k];
  const RowGroup& group = s.groups[g];
  PackedStage& p = system.stages_[k];
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
  bool has_lower = false, has_upper = false;
  for (int i = 0; i < group.rows; ++i) {
    const double l = group.lower[i], u = group.upper[i];
    if (std::isnan(l) || std::isnan(u) || l > u) {
      ok = false;
      return;
    }
    if ((l == u && !group.soft) != equalities || (l == -infinity && u == infinity)) continue;
    if (p.constant_states > 0 && !group.soft && is_settled(k, g, i)) {
      continue;
    }
    source[rows++] = i;
    has_lower = has_lower || l != -infinity;
    has_upper = has_upper || u != infinity;
  }
  if (rows == 0) return;
  int columns = 0, part = 0;
  for (int c = 0; c < all_columns; ++c) {
    const Column at = column_of(k, group.columns[c]);
    if (at.part < 0) continue;
    part = at.part;
    column[columns] = at.at;
    user_column[columns++] = c;
  }
  // Rows that touch the fixed start only cannot be influenced.
  if (columns == 0) return;
  const int own_columns = columns;
  if (part > 0) {
    columns = p.sweep.nu;
    for (int c = 0; c < columns; ++c) column[c] = c;
  }
  RowBlock& b = new_block(k, g, rows, columns, part);
  b.column = column;
  b.source = source;
  b.soft = group.soft;

  // The block of the stage before, if its coefficients are the same.
  const RowBlock* twin = nullptr;
  if (k > 0 && g < static_cast<int>(qp.stages[k - 1].groups.size()) && !equalities) {
    const RowGroup& other = qp.stages[k - 1].groups[g];
    for (const RowBlock& t : system.stages_[k - 1].rows) {
      if (t.group != g || t.equality_at >= 0 || t.rows != rows || t.columns != columns ||
          t.part != part || other.rows != group.rows ||
          other.columns.size() != group.columns.size())
        continue;
      if (part > 0 && system.stages_[k - 1].T != p.T) continue;
      if (part == 0 && own_columns != all_columns) continue;
      // Offsets in the stage vector may differ (a fixed start has no states), their order may not.
      const int shift = group.columns[0] - other.columns[0];
      const int allowed = group.columns[0] >= s.nx ? s.nx - qp.stages[k - 1].nx : 0;
      bool equal = shift == allowed && same(group.M, other.M, group.rows, all_columns) &&
                   std::equal(source, source + rows, t.source);
      for (int c = 1; equal && c < all_columns; ++c)
        equal = group.columns[c] - other.columns[c] == shift;
      if (equal) twin = &t;
    }
  }
  if (twin != nullptr) {
    b.C = twin->C;
  } else {
    const int ld = padded(rows);
    double* C = numbers(ld * columns);
    if (!ok) return;
    std::fill(C, C + ld * columns, 0.0);
    if (part == 0) {
      for (int c = 0; c < columns; ++c)
        for (int i = 0; i < rows; ++i) C[i + c * ld] = group.M(source[i], user_column[c]);
    } else {
      const int m = p.sweep.nu, ldm = padded(m);
      for (int c = 0; c < own_columns; ++c) {
        const int local = group.columns[user_column[c]] - s.nx - part * m;
        for (int j = 0; j < m; ++j) {
          const double t = p.T_inverse[local + ((part - 1) * m + j) * ldm];
          for (int i = 0; i < rows; ++i) C[i + j * ld] += group.M(source[i], user_column[c]) * t;
        }
      }
    }
    if (equalities) {
      double* scale = numbers(rows);
      if (!ok) return;
      for (int i = 0; i < rows; ++i) {
        double most = 0.0;
        for (int c = 0; c < columns; ++c) most = std::max(most, std::fabs(C[i + c * ld]));
        scale[i] = most > 0.0 ? 1.0 / most : 1.0;
        for (int c = 0; c < columns; ++c) C[i + c * ld] *= scale[i];
      }
      b.scale = scale;
    }
    b.C = C;
  }
  finish_block(k, b, twin);
  place_rows(b, equalities, has_lower, has_upper);
}

void RiccatiSystem::Packer::bounds(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = system.stages_[k];
  const int users = s.nx + s.nu;
  int first = users, last = -1, equal = 0;
  bool has_lower = false, has_upper = false;
  int further[max_parts] = {};  // bounded inputs per further part
  for (int j = p.constant_states; j < users; ++j) {
    const double l = lower_bound(s, j), u = upper_bound(s, j);
    if (std::isnan(l) || std::isnan(u) || l > u) {
      ok = false;
      return;
    }
    if (l == -infinity && u == infinity) continue;
    const Column at = column_of(k, j);
    if (at.part > 0) {
      ++further[at.part];
    } else if (l == u) {
      ++equal;
    } else {
      first = std::min(first, at.at);
      last = std::max(last, at.at);
      has_lower = has_lower || l != -infinity;
      has_upper = has_upper || u != infinity;
    }
  }
  p.bounds = BoundBlock{};
  if (last >= first) {
    p.bounds.first = first / lanes * lanes;
    p.bounds.length = padded(last + 1) - p.bounds.first;
    if (has_lower) p.bounds.lower_at = hard;
    if (has_lower) hard += p.bounds.length;
    if (has_upper) p.bounds.upper_at = hard;
    if (has_upper) hard += p.bounds.length;
  }
  if (equal > 0) add_bound_rows(k, 0, true);
  for (int part = 1; part < p.parts; ++part) {
    if (further[part] == 0) continue;
    add_bound_rows(k, part, false);
    add_bound_rows(k, part, true);
  }
}

// Bounds as rows: equal ones, and those of inputs that were replaced by their share of a resultant.
void RiccatiSystem::Packer::add_bound_rows(int k, int part, bool equalities) {
  const Stage& s = qp.stages[k];
  const PackedStage& p = system.stages_[k];
  const int users = s.nx + s.nu;
  int* source = integers(users);
  int* column = integers(users);
  if (!ok) return;
  int rows = 0, columns = 0;
  bool has_lower = false, has_upper = false;
  for (int j = p.constant_states; j < users; ++j) {
    const double l = lower_bound(s, j), u = upper_bound(s, j);
    const Column at = column_of(k, j);
    if (at.part != part || (l == -infinity && u == infinity) || (l == u) != equalities) continue;
    source[rows++] = j;
    column[columns++] = at.at;
    has_lower = has_lower || l != -infinity;
    has_upper = has_upper || u != infinity;
  }
  if (rows == 0) return;
  if (part > 0) {
    columns = p.sweep.nu;
    for (int c = 0; c < columns; ++c) column[c] = c;
  }
  RowBlock& b = new_block(k, -1, rows, columns, part);
  const int ld = padded(rows), ldm = padded(p.sweep.nu), m = p.sweep.nu;
  double* C = numbers(ld * columns);
  double* scale = numbers(rows);
  if (!ok) return;
  std::fill(C, C + ld * columns, 0.0);
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
  place_rows(b, equalities, has_lower, has_upper);
}

// Right-hand sides and prices, once every place is known.
void RiccatiSystem::Packer::fill_sides() {
  std::fill_n(system.active_.data(), system.sides_, 0.0);
  std::fill_n(system.beta_.data(), system.sides_, 0.0);
  std::fill_n(system.wanted_.data(), system.equalities_, 0.0);
  std::fill_n(system.l1_.data() + system.first_soft_, soft, 1.0);
  std::fill_n(system.l2_.data() + system.first_soft_, soft, 0.0);
  const auto set = [&](int at, double value, double sign) {
    if (!std::isfinite(value)) return;
    system.active_[at] = 1.0;
    system.beta_[at] = sign * value;
  };
  for (int k = 0; k < static_cast<int>(qp.stages.size()); ++k) {
    const Stage& s = qp.stages[k];
    const PackedStage& p = system.stages_[k];
    for (RowBlock& b : p.rows)
      for (int i = 0; i < b.rows; ++i) {
        const int from = b.source[i];
        double shift = 0.0, l, u;
        if (b.group >= 0) {
          const RowGroup& group = s.groups[b.group];
          for (int c = 0; p.constant_states > 0 && c < static_cast<int>(group.columns.size()); ++c)
            if (group.columns[c] < s.nx) shift += group.M(from, c) * qp.start[group.columns[c]];
          l = group.lower[from];
          u = group.upper[from];
        } else {
          l = lower_bound(s, from);
          u = upper_bound(s, from);
        }
        if (b.equality_at >= 0) {
          system.wanted_[b.equality_at + i] = (l - shift) * b.scale[i];
          continue;
        }
        b.partial =
            b.partial || (b.lower_at >= 0 && l == -infinity) || (b.upper_at >= 0 && u == infinity);
        if (b.lower_at >= 0) set(b.lower_at + i, l - shift, 1.0);
        if (b.upper_at >= 0) set(b.upper_at + i, u - shift, -1.0);
        if (!b.soft) continue;
        const RowGroup& group = s.groups[b.group];
        for (const int at : {b.lower_at, b.upper_at})
          if (at >= 0) {
            system.l1_[at + i] = group.l1[from];
            system.l2_[at + i] = group.l2[from];
          }
      }
    const BoundBlock& b = p.bounds;
    const int n = p.sweep.nx + p.sweep.nu;
    for (int i = 0; i < b.length && b.first + i < n; ++i) {
      const int j = b.first + i + p.constant_states;
      if (lower_bound(s, j) == upper_bound(s, j)) continue;
      if (b.lower_at >= 0) set(b.lower_at + i, lower_bound(s, j), 1.0);
      if (b.upper_at >= 0) set(b.upper_at + i, upper_bound(s, j), -1.0);
    }
  }
}

}  // namespace saltus::qp
