#include "framework/qp/riccati_system.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace saltus::qp {
namespace {

// Equality rows enter with a quadratic price on what the step leaves of them; their multipliers
// make up for it, so that at the solution they hold exactly. It must outweigh sides that depend on
// them.
constexpr double least_equality_price = 1e9, most_equality_price = 1e15;
constexpr double equality_price_per_weight = 10.0;
// Added to the Hessian when a step is computed, never to the problem: a proximal term.
constexpr double proximal_weight = 1e-11;
constexpr double least_pivot = 1e-13;
constexpr int max_parts = 8;
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

// --- packing ------------------------------------------------------------------------------------

struct RiccatiSystem::Packer {
  RiccatiSystem& system;
  const StageQp& qp;
  int v = 0, y = 0, hard = 0, soft = 0, blocks = 0;
  bool ok = true;
  bool starts_fixed(int k) const { return k == 0 && qp.fixed_start; }
  bool starts_free(int k) const { return k == 0 && !qp.fixed_start; }

  double* numbers(int count) {
    double* result = system.numbers_.take(count);
    if (result == nullptr) ok = false;
    return result;
  }
  int* integers(int count) {
    int* result = system.integers_.take(count);
    if (result == nullptr) ok = false;
    return result;
  }

  // Where entry j of the user's v = (x, u) went: part, and place in it; part -1: it is constant.
  struct Place {
    int part, at;
  };
  Place place(int k, int j) const {
    const Stage& s = qp.stages[k];
    const PackedStage& p = system.stages_[k];
    if (j < s.nx) return starts_fixed(k) ? Place{-1, 0} : Place{0, j};
    const int input = j - s.nx;
    if (p.parts == 1) return {0, (starts_fixed(k) ? 0 : s.nx) + input};
    const int size = p.sweep.nu;
    return {input / size, (input < size ? p.sweep.nx : 0) + input % size};
  }

  bool run();
  void stage(int k);
  void choose_parts(int k);
  bool resultant_maps(int k, int parts);
  void flow(int k);
  void cost(int k);
  void groups(int k);
  void bounds(int k);
  bool columns_fit_parts(const Stage& s, int size) const;
  RowBlock& new_block(int k, int group, int rows, int columns, int part);
  void finish_block(int k, RowBlock& block, const RowBlock* twin);
  void add_sides(RowBlock& block, bool has_lower, bool has_upper);
  void add_group(int k, int g, bool equalities);
  void add_bound_rows(int k, int part, bool equalities);
  void fill_sides();
  bool is_settled(int k, int g, int row);
};

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

// T_p with B_p = B_1 T_p: those of the stage before if they serve, else by elimination.
bool RiccatiSystem::Packer::resultant_maps(int k, int parts) {
  const Stage& s = qp.stages[k];
  PackedStage& p = system.stages_[k];
  const int m = s.resultant_size, nn = p.sweep.next, ld = padded(m), count = (parts - 1) * m;
  constexpr double rounding = 1e-11;  // of B's entries, well above what their computation loses
  double scale = 0.0;
  for (int j = 0; j < s.nu; ++j)
    for (int i = 0; i < nn; ++i) scale = std::max(scale, std::fabs(s.B(i, j)));
  const auto serves = [&](const double* T) {
    for (int c = 0; c < count; ++c)
      for (int i = 0; i < nn; ++i) {
        double sum = -s.B(i, m + c);
        for (int l = 0; l < m; ++l) sum += s.B(i, l) * T[l + c * ld];
        if (std::fabs(sum) > rounding * scale) return false;
      }
    return true;
  };
  if (k > 0) {
    const PackedStage& before = system.stages_[k - 1];
    if (before.parts == parts && before.sweep.nu == m &&
        (same(qp.stages[k - 1].B, s.B, nn, s.nu) || serves(before.T))) {
      p.T = before.T;
      p.T_inverse = before.T_inverse;
      return true;
    }
  }
  // Gauss-Jordan with row pivoting on [B_1 | B_2 ...]; the pivot rows then hold T.
  double* a = numbers(nn * s.nu);
  double* T = numbers(ld * count);
  double* inverse = numbers(ld * count);
  int* used = integers(nn);
  if (!ok) return false;
  for (int j = 0; j < s.nu; ++j)
    for (int i = 0; i < nn; ++i) a[i + j * nn] = s.B(i, j);
  std::fill(used, used + nn, -1);
  for (int c = 0; c < m; ++c) {
    int pivot = -1;
    for (int i = 0; i < nn; ++i)
      if (used[i] < 0 && (pivot < 0 || std::fabs(a[i + c * nn]) > std::fabs(a[pivot + c * nn])))
        pivot = i;
    if (pivot < 0 || std::fabs(a[pivot + c * nn]) <= rounding * scale) return false;
    used[pivot] = c;
    const double inverse_pivot = 1.0 / a[pivot + c * nn];
    for (int j = c; j < s.nu; ++j) a[pivot + j * nn] *= inverse_pivot;
    for (int i = 0; i < nn; ++i) {
      if (i == pivot) continue;
      const double f = a[i + c * nn];
      if (f == 0.0) continue;
      for (int j = c; j < s.nu; ++j) a[i + j * nn] -= f * a[pivot + j * nn];
    }
  }
  std::fill(T, T + ld * count, 0.0);
  std::fill(inverse, inverse + ld * count, 0.0);
  for (int i = 0; i < nn; ++i)
    if (used[i] >= 0)
      for (int c = 0; c < count; ++c) T[used[i] + c * ld] = a[i + (m + c) * nn];
  if (!serves(T)) return false;
  for (int part = 0; part + 1 < parts; ++part) {
    Eigen::Map<const MatrixXd, 0, Eigen::OuterStride<>> forward(T + part * m * ld, m, m,
                                                                Eigen::OuterStride<>(ld));
    // Gauss-Jordan once more, on [T_p | I]; a is large enough for m x 2m.
    double* w = system.work_.data();
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < m; ++i) {
        w[i + j * m] = forward(i, j);
        w[i + (m + j) * m] = i == j ? 1.0 : 0.0;
      }
    for (int c = 0; c < m; ++c) {
      int pivot = c;
      for (int i = c + 1; i < m; ++i)
        if (std::fabs(w[i + c * m]) > std::fabs(w[pivot + c * m])) pivot = i;
      if (std::fabs(w[pivot + c * m]) < 1e-8) return false;  // nearly singular: not a resultant
      for (int j = 0; j < 2 * m; ++j) std::swap(w[c + j * m], w[pivot + j * m]);
      const double f = 1.0 / w[c + c * m];
      for (int j = 0; j < 2 * m; ++j) w[c + j * m] *= f;
      for (int i = 0; i < m; ++i) {
        if (i == c) continue;
        const double g = w[i + c * m];
        for (int j = 0; j < 2 * m; ++j) w[i + j * m] -= g * w[c + j * m];
      }
    }
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < m; ++i) inverse[i + (part * m + j) * ld] = w[i + (m + j) * m];
  }
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

void RiccatiSystem::Packer::add_sides(RowBlock& b, bool has_lower, bool has_upper) {
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
    const Place at = place(k, group.columns[c]);
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
  if (!ok) return;
  if (equalities) {
    system.has_equality_rows_ = true;
    b.equality_at = y;
    y += padded(rows);
  } else {
    add_sides(b, has_lower, has_upper);
  }
}

void RiccatiSystem::Packer::bounds(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = system.stages_[k];
  const int users = s.nx + s.nu;
  int first = users, last = -1, equal = 0;
  bool has_lower = false, has_upper = false;
  const auto sides_of = [&](int j, double& l, double& u) {
    l = j < s.nx ? s.x_lower[j] : s.u_lower[j - s.nx];
    u = j < s.nx ? s.x_upper[j] : s.u_upper[j - s.nx];
  };
  int further[max_parts] = {};  // bounded inputs per further part
  for (int j = p.constant_states; j < users; ++j) {
    double l, u;
    sides_of(j, l, u);
    if (std::isnan(l) || std::isnan(u) || l > u) {
      ok = false;
      return;
    }
    if (l == -infinity && u == infinity) continue;
    const Place at = place(k, j);
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
    const double l = j < s.nx ? s.x_lower[j] : s.u_lower[j - s.nx];
    const double u = j < s.nx ? s.x_upper[j] : s.u_upper[j - s.nx];
    const Place at = place(k, j);
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
  if (!ok) return;
  if (equalities) {
    system.has_equality_rows_ = true;
    b.equality_at = y;
    y += padded(rows);
  } else {
    add_sides(b, has_lower, has_upper);
  }
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
    const auto lower_of = [&](int j) { return j < s.nx ? s.x_lower[j] : s.u_lower[j - s.nx]; };
    const auto upper_of = [&](int j) { return j < s.nx ? s.x_upper[j] : s.u_upper[j - s.nx]; };
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
          l = lower_of(from);
          u = upper_of(from);
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
      if (lower_of(j) == upper_of(j)) continue;
      if (b.lower_at >= 0) set(b.lower_at + i, lower_of(j), 1.0);
      if (b.upper_at >= 0) set(b.upper_at + i, upper_of(j), -1.0);
    }
  }
}

RiccatiSystem::RiccatiSystem(const StageQp& capacity, std::span<const RiccatiKernel> kernels)
    : kernels_(kernels.begin(), kernels.end()), stages_(capacity.stages.size()) {
  std::size_t doubles = 0, ints = 0;
  int blocks = 0, work = 64;
  for (std::size_t k = 0; k < capacity.stages.size(); ++k) {
    const Stage& s = capacity.stages[k];
    const int nx = static_cast<int>(s.q.size()), nu = static_cast<int>(s.r.size());
    const int next = static_cast<int>(s.b.size());
    const int n = nx + nu, ld = padded(n), spare = 8;
    const auto matrix = [&](int rows, int columns) {
      return static_cast<std::size_t>(padded(rows) + spare) * static_cast<std::size_t>(columns + 1);
    };
    // Stage matrices; those of parts are bounded by full ones of the inputs.
    doubles += matrix(next, n) + matrix(n, next) + 3 * matrix(n, n) + 4 * matrix(n, 1) +
               matrix(next, 1) + 8 * matrix(nu, nu) + matrix(next, nu) +
               8 * max_parts * matrix(nu, 1);
    ints += static_cast<std::size_t>(8 * (n + next + 16));
    int v = ld + max_parts * lanes + padded(nu), y = padded(next), sides = 2 * (ld + lanes);
    const auto rows = [&](int count, int columns) {
      const int c = std::max(columns, nu);
      doubles += 2 * (matrix(count, c) + matrix(c, count) + matrix(count, 1) +
                      (c <= max_pair_columns ? matrix(pairs_of(c), count) : matrix(1, 1)));
      // Few columns keep the products of pairs even where others would need more of them.
      doubles += 2 * matrix(pairs_of(max_pair_columns), count);
      ints += static_cast<std::size_t>(2 * (count + 2 * c + pairs_of(c) + 64));
      y += padded(count) + lanes;
      sides += 2 * (padded(count) + lanes);
      blocks += 2;
      work = std::max(work, padded(count) * (c + 2) + padded(c) * (c + 2));
    };
    for (const RowGroup& g : s.groups)
      rows(static_cast<int>(g.M.rows()), static_cast<int>(g.M.cols()));
    for (int part = 0; part < max_parts && (part == 0 || part < nu); ++part)
      rows(part == 0 ? n : nu, part == 0 ? n : nu);
    work = std::max({work, (padded(next) + 8) * (n + 2), 8 * (padded(nu) + 8) * (nu + 2)});
    max_variables_ += v;
    max_equalities_ += y;
    max_sides_ += sides;
  }
  numbers_ = Arena<double, AlignedArray>(doubles);
  integers_ = Arena<int, std::vector<int>>(ints);
  blocks_.resize(blocks);
  splits_.resize((max_parts - 1) * capacity.stages.size());
  active_ = AlignedArray(max_sides_);
  beta_ = AlignedArray(max_sides_);
  l1_ = AlignedArray(max_sides_);
  l2_ = AlignedArray(max_sides_);
  weights_ = AlignedArray(max_sides_);
  side_work_ = AlignedArray(max_sides_);
  wanted_ = AlignedArray(max_equalities_);
  work_ = AlignedArray(2 * work);
  gradient_ = AlignedArray(max_variables_);
  residual_v_ = AlignedArray(max_variables_);
  correction_v_ = AlignedArray(max_variables_);
  residual_y_ = AlignedArray(max_equalities_);
  correction_y_ = AlignedArray(max_equalities_);
  row_work_ = AlignedArray(work);
  sum_ = AlignedArray(work);
}

bool RiccatiSystem::pack(const StageQp& qp) {
  replaced_pivots_ = 0;
  Packer packer{*this, qp};
  if (!packer.run()) return false;
  packer.fill_sides();
  return true;
}

void RiccatiSystem::pack_point(const StageQp& qp, const StagePoint& point, bool multipliers,
                               double* v, double* y, double* lambda) const {
  std::fill_n(v, variables_, 0.0);
  if (multipliers) {
    std::fill_n(y, equalities_, 0.0);
    std::fill_n(lambda, sides_, 0.0);
  }
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const Stage& s = qp.stages[k];
    const PackedStage& p = stages_[k];
    const StagePoint::AtStage& from = point.stages[k];
    const int m = p.sweep.nu, ldm = padded(m);
    double* main = v + p.v_at;
    for (int j = p.constant_states; j < s.nx; ++j) main[j] = from.x[j];
    const int own = p.parts > 1 ? m : s.nu, shift = s.nx - p.constant_states;
    for (int j = 0; j < own; ++j) main[shift + j] = from.u[j];
    for (int part = 1; part < p.parts; ++part) {
      double* to = main + p.sweep.ld + (part - 1) * ldm;
      for (int c = 0; c < m; ++c)
        for (int i = 0; i < m; ++i)
          to[i] += p.T[i + ((part - 1) * m + c) * ldm] * from.u[part * m + c];
    }
    if (!multipliers) continue;
    for (int i = 0; i < p.sweep.next; ++i) y[p.costate_at + i] = from.costate[i];
    for (const RowBlock& b : p.rows)
      for (int i = 0; i < b.rows; ++i) {
        const int j = b.source[i];
        const double value = b.group >= 0 ? from.group[b.group][j]
                             : j < s.nx   ? from.x_bound[j]
                                          : from.u_bound[j - s.nx];
        if (b.equality_at >= 0) y[b.equality_at + i] = value / b.scale[i];
        if (b.upper_at >= 0) lambda[b.upper_at + i] = std::max(value, 0.0);
        if (b.lower_at >= 0) lambda[b.lower_at + i] = std::max(-value, 0.0);
      }
    const int n = p.sweep.nx + p.sweep.nu;
    for (int i = 0; i < p.bounds.length && p.bounds.first + i < n; ++i) {
      const int j = p.bounds.first + i + p.constant_states;
      const double value = j < s.nx ? from.x_bound[j] : from.u_bound[j - s.nx];
      if (p.bounds.upper_at >= 0) lambda[p.bounds.upper_at + i] = std::max(value, 0.0);
      if (p.bounds.lower_at >= 0) lambda[p.bounds.lower_at + i] = std::max(-value, 0.0);
    }
  }
}

// Soft rows of the fixed start alone are no part of the packed program; what they miss has a price.
void RiccatiSystem::price_settled_rows(const StageQp& qp, StagePoint::AtStage& to) const {
  const Stage& s = qp.stages.front();
  for (std::size_t g = 0; g < s.groups.size(); ++g) {
    const RowGroup& group = s.groups[g];
    const bool settled =
        std::all_of(group.columns.begin(), group.columns.end(), [&](int j) { return j < s.nx; });
    if (!group.soft || !settled) continue;
    for (int i = 0; i < group.rows; ++i) {
      double value = 0.0;
      for (std::size_t c = 0; c < group.columns.size(); ++c)
        value += group.M(i, static_cast<int>(c)) * qp.start[group.columns[c]];
      if (value > group.upper[i])
        to.group[g][i] = group.l1[i] + group.l2[i] * (value - group.upper[i]);
      if (value < group.lower[i])
        to.group[g][i] = -group.l1[i] - group.l2[i] * (group.lower[i] - value);
    }
  }
}

void RiccatiSystem::unpack_point(const StageQp& qp, const double* v, const double* y,
                                 const double* lambda, StagePoint& point) const {
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const Stage& s = qp.stages[k];
    const PackedStage& p = stages_[k];
    StagePoint::AtStage& to = point.stages[k];
    const int m = p.sweep.nu, ldm = padded(m);
    const double* main = v + p.v_at;
    for (int j = 0; j < s.nx; ++j) to.x[j] = j < p.constant_states ? qp.start[j] : main[j];
    const int own = p.parts > 1 ? m : s.nu, shift = s.nx - p.constant_states;
    for (int j = 0; j < own; ++j) to.u[j] = main[shift + j];
    for (int part = 1; part < p.parts; ++part) {
      const double* from = main + p.sweep.ld + (part - 1) * ldm;
      for (int i = 0; i < m; ++i) {
        double sum = 0.0;
        for (int c = 0; c < m; ++c) sum += p.T_inverse[i + ((part - 1) * m + c) * ldm] * from[c];
        to.u[part * m + i] = sum;
      }
    }
    for (int i = 0; i < p.sweep.next; ++i) to.costate[i] = y[p.costate_at + i];
    to.x_bound.setZero();
    to.u_bound.setZero();
    for (VectorXd& g : to.group) g.setZero();
    const auto add = [&](int group, int j, double value) {
      if (group >= 0)
        to.group[group][j] += value;
      else if (j < s.nx)
        to.x_bound[j] += value;
      else
        to.u_bound[j - s.nx] += value;
    };
    for (const RowBlock& b : p.rows)
      for (int i = 0; i < b.rows; ++i) {
        if (b.equality_at >= 0) add(b.group, b.source[i], y[b.equality_at + i] * b.scale[i]);
        if (b.upper_at >= 0) add(b.group, b.source[i], lambda[b.upper_at + i]);
        if (b.lower_at >= 0) add(b.group, b.source[i], -lambda[b.lower_at + i]);
      }
    const int n = p.sweep.nx + p.sweep.nu;
    for (int i = 0; i < p.bounds.length && p.bounds.first + i < n; ++i) {
      const int j = p.bounds.first + i + p.constant_states;
      if (p.bounds.upper_at >= 0) add(-1, j, lambda[p.bounds.upper_at + i]);
      if (p.bounds.lower_at >= 0) add(-1, j, -lambda[p.bounds.lower_at + i]);
    }
    if (p.constant_states > 0) price_settled_rows(qp, to);
  }
}

void RiccatiSystem::roll_out(double* v) {
  for (std::size_t k = 0; k + 1 < stages_.size(); ++k) {
    const PackedStage& p = stages_[k];
    const int nn = p.sweep.next, n = p.sweep.nx + p.sweep.nu;
    const double* main = with_resultant(p, v);
    double* next = work_.data();
    for (int i = 0; i < p.sweep.ld_next; i += lanes) store(next + i, load(p.b + i));
    multiply_vector<Update::add>(nn, n, p.sweep.flow, p.sweep.ld_next, main, next);
    std::copy(next, next + nn, v + stages_[k + 1].v_at);
  }
}

// --- products -----------------------------------------------------------------------------------

// The stage's main variables, with the inputs of further parts added to those of the first: what
// the dynamics see.
const double* RiccatiSystem::with_resultant(const PackedStage& p, const double* v) {
  const double* main = v + p.v_at;
  if (p.parts == 1) return main;
  const SweepStage& w = p.sweep;
  double* sum = sum_.data();
  for (int i = 0; i < w.ld; i += lanes) store(sum + i, load(main + i));
  for (int part = 1; part < p.parts; ++part) {
    const double* further = main + w.ld + (part - 1) * padded(w.nu);
    for (int i = 0; i < w.nu; ++i) sum[w.nx + i] += further[i];
  }
  return sum;
}

template <bool affine>
void RiccatiSystem::products(const double* v, const double* y, double* stationarity,
                             double* equality) {
  const double* costate = nullptr;  // of the dynamics that lead into the stage
  double* force = work_.data();
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const PackedStage& p = stages_[k];
    const SweepStage& w = p.sweep;
    const int ldm = padded(w.nu);
    const double* main = v + p.v_at;
    double* out = stationarity + p.v_at;
    const double* pi = y + p.costate_at;
    double* gap = equality + p.costate_at;
    for (int i = 0; i < w.ld; i += lanes) store(out + i, affine ? load(p.g + i) : Lanes{});
    for (int i = 0; i < w.ld_next; i += lanes) store(gap + i, affine ? load(p.b + i) : Lanes{});
    p.kernel->products(w, p.H, main, with_resultant(p, v), pi,
                       w.next > 0 ? v + stages_[k + 1].v_at : nullptr, out, force, gap);
    for (int i = 0; i < w.nx && costate != nullptr; ++i) out[i] -= costate[i];
    if (w.next > 0)
      for (int i = 0; i < w.ld; i += lanes) store(out + i, load(out + i) + load(force + i));
    for (int part = 1; part < p.parts; ++part) {
      const double* further = main + w.ld + (part - 1) * ldm;
      double* to = out + w.ld + (part - 1) * ldm;
      for (int i = 0; i < ldm; i += lanes)
        store(to + i, affine ? load(p.r + (part - 1) * ldm + i) : Lanes{});
      multiply_vector<Update::add>(w.nu, w.nu, p.R + (part - 1) * ldm * w.nu, ldm, further, to);
      for (int i = 0; i < w.nu; ++i) to[i] += force[w.nx + i];
    }
    costate = pi;
  }
  if (!has_equality_rows_) return;
  for (const PackedStage& p : stages_)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      b.kernel->multiply(b, v + b.v_at, 1.0, equality + b.equality_at);
      if (affine)
        for (int i = 0; i < padded(b.rows); ++i)
          equality[b.equality_at + i] -= wanted_[b.equality_at + i];
      b.kernel->add_transposed(b, y + b.equality_at, 1.0, stationarity + b.v_at);
    }
}

void RiccatiSystem::multiply(const double* v, double* side) {
  const auto mask = [&](int at, int rows) {
    for (int i = at; i < at + padded(rows); i += lanes)
      store(side + i, load(side + i) * load(&active_[i]));
  };
  for (const PackedStage& p : stages_) {
    for (const RowBlock& b : p.rows) {
      if (b.equality_at >= 0) continue;
      if (b.upper_at >= 0) b.kernel->multiply(b, v + b.v_at, -1.0, side + b.upper_at);
      if (b.lower_at >= 0 && b.upper_at >= 0)
        for (int i = 0; i < padded(b.rows); i += lanes)
          store(side + b.lower_at + i, -load(side + b.upper_at + i));
      else if (b.lower_at >= 0)
        b.kernel->multiply(b, v + b.v_at, 1.0, side + b.lower_at);
      if (b.partial && b.lower_at >= 0) mask(b.lower_at, b.rows);
      if (b.partial && b.upper_at >= 0) mask(b.upper_at, b.rows);
    }
    const BoundBlock& b = p.bounds;
    for (int i = 0; i < b.length; i += lanes) {
      const Lanes x = load(v + p.v_at + b.first + i);
      if (b.lower_at >= 0) store(side + b.lower_at + i, x * load(&active_[b.lower_at + i]));
      if (b.upper_at >= 0) store(side + b.upper_at + i, -x * load(&active_[b.upper_at + i]));
    }
  }
}

template <int sign>
void RiccatiSystem::add_sides(const double* side, double* v) {
  double* rows = work_.data();
  for (const PackedStage& p : stages_) {
    for (const RowBlock& b : p.rows) {
      if (b.equality_at >= 0) continue;
      if (b.lower_at < 0) {
        b.kernel->add_transposed(b, side + b.upper_at, -sign, v + b.v_at);
      } else if (b.upper_at < 0) {
        b.kernel->add_transposed(b, side + b.lower_at, sign, v + b.v_at);
      } else {
        for (int i = 0; i < padded(b.rows); i += lanes)
          store(rows + i, load(side + b.lower_at + i) - load(side + b.upper_at + i));
        b.kernel->add_transposed(b, rows, sign, v + b.v_at);
      }
    }
    const BoundBlock& b = p.bounds;
    for (int i = 0; i < b.length; i += lanes) {
      double* to = v + p.v_at + b.first + i;
      Lanes sum{};
      if (b.lower_at >= 0) sum += load(side + b.lower_at + i) * load(&active_[b.lower_at + i]);
      if (b.upper_at >= 0) sum -= load(side + b.upper_at + i) * load(&active_[b.upper_at + i]);
      store(to, load(to) + (sign > 0 ? sum : -sum));
    }
  }
}

void RiccatiSystem::multiply_transposed(const double* side, double* v) {
  for (int i = 0; i < variables_; i += lanes) store(v + i, Lanes{});
  add_sides<1>(side, v);
}

void RiccatiSystem::evaluate(const double* v, const double* y, const double* lambda,
                             double* stationarity, double* equality, double* side) {
  products<true>(v, y, stationarity, equality);
  add_sides<-1>(lambda, stationarity);
  multiply(v, side);
}

void RiccatiSystem::apply(const double* v, const double* y, const double* lambda,
                          double* stationarity, double* equality, double* side) {
  products<false>(v, y, stationarity, equality);
  add_sides<-1>(lambda, stationarity);
  multiply(v, side);
}

double RiccatiSystem::cost(const double* v) {
  double* slope = work_.data();
  double total = 0.0;
  // v'(1/2 H v + g) of one block.
  const auto add = [&](int size, const double* H, const double* g, const double* at) {
    multiply_vector<Update::set>(size, size, H, padded(size), at, slope);
    for (int i = 0; i < size; ++i) total += (0.5 * slope[i] + g[i]) * at[i];
  };
  for (const PackedStage& p : stages_) {
    const int m = p.sweep.nu, ldm = padded(m);
    const double* main = v + p.v_at;
    add(p.sweep.nx + m, p.H, p.g, main);
    for (int part = 0; part + 1 < p.parts; ++part)
      add(m, p.R + part * ldm * m, p.r + part * ldm, main + p.sweep.ld + part * ldm);
  }
  return total;
}

// --- factorisation ------------------------------------------------------------------------------

void RiccatiSystem::add_rows(PackedStage& p, const double* weights) {
  double* row_weights = work_.data();
  for (const RowBlock& b : p.rows) {
    const int ld = padded(b.rows);
    for (int i = 0; i < ld; i += lanes) {
      Lanes sum{};
      if (b.lower_at >= 0) sum += load(weights + b.lower_at + i);
      if (b.upper_at >= 0) sum += load(weights + b.upper_at + i);
      if (b.equality_at >= 0) sum = broadcast(equality_price_);
      store(row_weights + i, sum);
    }
    double* H = b.part == 0 ? p.sweep.M : p.R_work + (b.part - 1) * padded(p.sweep.nu) * p.sweep.nu;
    double* result = row_weights + ld;
    if (b.pairs != nullptr) {
      b.kernel->add_square(b, row_weights, H, result);
      continue;
    }
    // More columns: C'(W C) as a product.
    const int ldc = padded(b.columns);
    double* weighted = result;
    double* square = weighted + ld * b.columns;
    for (int c = 0; c < b.columns; ++c)
      for (int i = 0; i < ld; i += lanes)
        store(weighted + c * ld + i, load(b.C + c * ld + i) * load(row_weights + i));
    multiply_upper<Update::set>(b.columns, b.rows, b.Ct, ldc, weighted, 1, ld, square, ldc);
    for (int j = 0, at = 0; j < b.columns; ++j)
      for (int i = 0; i <= j; ++i) H[b.target[at++]] += square[i + j * ldc];
  }
  const BoundBlock& b = p.bounds;
  const int n = p.sweep.nx + p.sweep.nu;
  for (int i = 0; i < b.length && b.first + i < n; ++i) {
    double w = 0.0;
    if (b.lower_at >= 0) w += weights[b.lower_at + i] * active_[b.lower_at + i];
    if (b.upper_at >= 0) w += weights[b.upper_at + i] * active_[b.upper_at + i];
    p.sweep.M[(b.first + i) * (p.sweep.ld + 1)] += w;
  }
}

// The joint Hessian of the parts takes the place of the first part's.
void RiccatiSystem::factor_parts(PackedStage& p) {
  const SweepStage& w = p.sweep;
  for (int part = 1; part < p.parts; ++part)
    p.split_kernel->join(w.nu, w.M + w.nx * (w.ld + 1), w.ld, p.splits[part - 1], work_.data(),
                         least_pivot);
}

bool RiccatiSystem::factor(const double* weights) {
  if (has_equality_rows_) {
    Lanes most{};
    for (int i = 0; i < sides_; i += lanes) {
      store(&weights_[i], load(weights + i));
      most = larger(most, load(weights + i));
    }
    equality_price_ = std::clamp(equality_price_per_weight * largest(most), least_equality_price,
                                 most_equality_price);
  }
  const double* P = nullptr;
  int ld_P = 0;
  int replaced = 0;
  double check = 0.0;
  for (int k = static_cast<int>(stages_.size()) - 1; k >= 0; --k) {
    PackedStage& p = stages_[k];
    SweepStage& w = p.sweep;
    const int n = w.nx + w.nu;
    for (int i = 0; i < w.ld * n; i += lanes) store(w.M + i, load(p.H + i));
    for (int i = 0; i < n; ++i) w.M[i * (w.ld + 1)] += proximal_weight;
    const int further = (p.parts - 1) * padded(w.nu) * w.nu;
    for (int i = 0; i < further; i += lanes) store(p.R_work + i, load(p.R + i));
    add_rows(p, weights);
    if (p.parts > 1) factor_parts(p);
    replaced += p.kernel->factor(w, P, ld_P, work_.data(), least_pivot);
    P = w.M;
    ld_P = w.ld;
    for (int j = 0; j < w.nu; ++j) check += w.pivot[j];
  }
  replaced_pivots_ += replaced;
  return std::isfinite(check);
}

// --- solution -----------------------------------------------------------------------------------

void RiccatiSystem::sweep(const double* gradient, const double* equality, double* dv, double* dy) {
  const SweepStage* next = nullptr;
  for (int k = static_cast<int>(stages_.size()) - 1; k >= 0; --k) {
    PackedStage& p = stages_[k];
    SweepStage& w = p.sweep;
    const double* g = gradient + p.v_at;
    for (int i = 0; i < w.ld; i += lanes) store(w.p + i, load(g + i));
    for (int part = 1; part < p.parts; ++part)
      p.split_kernel->gather(w.nu, p.splits[part - 1], g + w.ld + (part - 1) * padded(w.nu),
                             w.p + w.nx, work_.data());
    p.kernel->backward(w, next ? next->M : nullptr, next ? next->ld : 0, next ? next->p : nullptr,
                       equality + p.costate_at, work_.data());
    next = &w;
  }
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const PackedStage& p = stages_[k];
    const SweepStage& w = p.sweep;
    double* v = dv + p.v_at;
    const bool last = k + 1 == stages_.size();
    const SweepStage* after = last ? nullptr : &stages_[k + 1].sweep;
    p.kernel->forward(w, last ? nullptr : after->M, last ? 0 : after->ld, last ? nullptr : after->p,
                      equality + p.costate_at, v, last ? nullptr : dv + stages_[k + 1].v_at,
                      dy + p.costate_at);
    const int n = w.nx + w.nu;
    for (int i = n; i < w.ld; ++i) v[i] = 0.0;
    for (int part = p.parts - 1; part > 0; --part)
      p.split_kernel->share(w.nu, p.splits[part - 1], v + w.nx,
                            v + w.ld + (part - 1) * padded(w.nu), work_.data());
  }
}

void RiccatiSystem::solve(const double* gradient, const double* equality, double* dv, double* dy) {
  if (!has_equality_rows_) {
    sweep(gradient, equality, dv, dy);
    return;
  }
  solve_with_rows(gradient, equality, dv, dy);
  // The price on equality rows is steep: what rounding loses is won back by a second solve.
  for (int round = 0; round < 2; ++round) {
    products<false>(dv, dy, residual_v_.data(), residual_y_.data());
    multiply(dv, side_work_.data());
    for (int i = 0; i < sides_; i += lanes)
      store(&side_work_[i], load(&side_work_[i]) * load(&weights_[i]));
    add_sides<1>(side_work_.data(), residual_v_.data());
    for (int i = 0; i < variables_; i += lanes)
      store(&residual_v_[i], load(&residual_v_[i]) + load(gradient + i));
    for (int i = 0; i < equalities_; i += lanes)
      store(&residual_y_[i], load(&residual_y_[i]) + load(equality + i));
    solve_with_rows(residual_v_.data(), residual_y_.data(), correction_v_.data(),
                    correction_y_.data());
    for (int i = 0; i < variables_; i += lanes)
      store(dv + i, load(dv + i) + load(&correction_v_[i]));
    for (int i = 0; i < equalities_; i += lanes)
      store(dy + i, load(dy + i) + load(&correction_y_[i]));
  }
}

// Equality rows E dv = -equality, priced: dy = price (E dv + equality).
void RiccatiSystem::solve_with_rows(const double* gradient, const double* equality, double* dv,
                                    double* dy) {
  double* scaled = row_work_.data();
  for (int i = 0; i < variables_; i += lanes) store(&gradient_[i], load(gradient + i));
  for (const PackedStage& p : stages_)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      for (int i = 0; i < padded(b.rows); i += lanes)
        store(scaled + i, load(equality + b.equality_at + i) * equality_price_);
      b.kernel->add_transposed(b, scaled, 1.0, gradient_.data() + b.v_at);
    }
  sweep(gradient_.data(), equality, dv, dy);
  for (const PackedStage& p : stages_)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      double* out = dy + b.equality_at;
      b.kernel->multiply(b, dv + b.v_at, 1.0, out);
      for (int i = 0; i < padded(b.rows); i += lanes)
        store(out + i, (load(out + i) + load(equality + b.equality_at + i)) * equality_price_);
    }
}

}  // namespace saltus::qp
