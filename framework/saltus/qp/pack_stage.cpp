// Packing of one stage without its rows: parts, sizes, dynamics and cost.
//
// Stage k: x_next = A x + B u + b, cost 1/2 x'Qx + u'Sx + 1/2 u'Ru + q'x + r'u. Packed: v = (x, u),
// x_next = F v + b with F = [A B], cost 1/2 v'Hv + g'v. Further inputs w = T_p u_p have the Hessian
// T_p^-T R_p T_p^-1 and the gradient T_p^-T r_p.
#include <algorithm>
#include <array>

#include "saltus/qp/packing.hpp"
#include "saltus/qp/resultant.hpp"

namespace saltus::qp {
namespace {

constexpr RiccatiKernel any_size = riccati_kernel<-1, -1, -1>();
// The last kernel fits every size.
constexpr SplitKernel split_kernels[] = {split_kernel<3>(), split_kernel<6>(), split_kernel<-1>()};

bool is_zero(const MatrixXd& a, int row, int column, int rows, int columns) {
  for (int j = column; j < column + columns; ++j)
    for (int i = row; i < row + rows; ++i)
      if (a(i, j) != 0.0) return false;
  return true;
}

// True if no row of the stage has columns in more than one group of `size` inputs.
bool rows_separate_parts(const Stage& s, int size) {
  for (const RowGroup& g : s.groups) {
    if (g.rows == 0 || g.columns.empty()) continue;
    const auto part_of = [&](int j) { return j < s.nx ? -1 : (j - s.nx) / size; };
    const int part = part_of(g.columns.front());
    for (const int j : g.columns)
      if (part_of(j) != part) return false;
  }
  return true;
}

// Finds the last rows of the flow that form an identity, and between their columns and the others
// the longest run of zero columns in whole vectors.
void find_copied_inputs(SweepStage& w) {
  const int n = w.nx + w.nu;
  w.dense = w.next;
  w.first_copied = n;
  w.zero_begin = w.zero_end = 0;
  for (; w.dense > 0; --w.dense) {
    const double* row = w.flow_transposed + (w.dense - 1) * w.ld;
    const double* entry = std::find_if(row, row + n, [](double a) { return a != 0.0; });
    const int at = static_cast<int>(entry - row);
    const bool follows = w.dense == w.next || at + 1 == w.first_copied;
    if (at == n || *entry != 1.0 || !follows ||
        std::any_of(entry + 1, row + n, [](double a) { return a != 0.0; }))
      break;
    w.first_copied = at;
  }
  if (w.dense == w.next) return;
  const auto is_zero_column = [&](int j) {
    const double* column = w.flow + j * w.ld_next;
    return std::all_of(column, column + w.next, [](double a) { return a == 0.0; });
  };
  int begin = 0;
  for (int j = 0; j <= n; ++j) {
    if (j < n && is_zero_column(j)) continue;
    const int from = padded(begin), to = j / lanes * lanes;
    if (to - from > w.zero_end - w.zero_begin) {
      w.zero_begin = from;
      w.zero_end = to;
    }
    begin = j + 1;
  }
}

bool fits(const RiccatiKernel& kernel, const SweepStage& w) {
  if (kernel.nx != w.nx || kernel.nu != w.nu || kernel.next != w.next) return false;
  if (!kernel.copies_inputs) return true;
  const bool is_known_zero = kernel.zero_begin == kernel.zero_end ||
                             (w.zero_begin <= kernel.zero_begin && kernel.zero_end <= w.zero_end);
  return w.dense + w.nu == w.next && w.first_copied == w.nx && is_known_zero;
}

// Computes y = T_p^-T x. The inverses are stored one below the other as in PackedStage.
void to_common_inputs(const double* T_inverse, int part, int size, const double* x, double* y) {
  const int ld = padded(size);
  for (int c = 0; c < size; ++c) {
    const double* column = T_inverse + (part * size + c) * ld;
    y[c] = 0.0;
    for (int i = 0; i < size; ++i) y[c] += column[i] * x[i];
  }
}

}  // namespace

bool Packing::stage(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = to.stages[k];
  if (s.nx > s.q.size() || s.nu > s.r.size()) return false;
  p.constant_states = starts_fixed(k) ? s.nx : 0;
  p.free_states = starts_free(k) ? s.nx : 0;
  SweepStage& w = p.sweep;
  w.nx = k == 0 ? 0 : s.nx;
  w.next = k == qp.intervals() ? 0 : qp.stages[k + 1].nx;
  choose_parts(k);
  w.nu = p.free_states + s.nu / p.parts;
  const int n = w.nx + w.nu;
  w.ld = padded(n);
  w.ld_next = padded(w.next);
  w.L = numbers(w.ld * w.nu);
  w.pivot = numbers(padded(w.nu));
  w.p = numbers(w.ld);
  p.v_at = v;
  v += w.ld + (p.parts - 1) * padded(w.nu);
  p.costate_at = y;
  y += w.ld_next;
  if (ok) dynamics(k);
  p.kernel = &any_size;
  for (const RiccatiKernel& kernel : to.storage.kernels)
    if (fits(kernel, w) && (kernel.copies_inputs || !p.kernel->copies_inputs)) p.kernel = &kernel;
  p.b = numbers(w.ld_next);
  p.g = numbers(w.ld);
  p.r = p.parts > 1 ? numbers((p.parts - 1) * padded(w.nu)) : nullptr;
  if (ok) vectors(k);
  if (ok) hessian(k);
  return ok;
}

// The recursion goes from the last stage to the first. Once M is eliminated, only its block P of
// the states is read. The previous stage starts to write behind P, in memory that is still in the
// cache.
bool Packing::allocate_recursion() {
  int kept = 0, most = 0;
  for (const PackedStage& p : to.stages) {
    kept += p.sweep.nx * p.sweep.ld;
    most = std::max(most, p.sweep.nu * p.sweep.ld);
  }
  double* work = numbers(kept + most);
  for (int k = qp.intervals(); k >= 0 && ok; --k) {
    SweepStage& w = to.stages[k].sweep;
    w.M = work;
    work += w.nx * w.ld;
  }
  return ok;
}

// True if the Hessian equals that of the previous stage.
bool Packing::has_same_cost_as_previous(int k) {
  if (cost_compared != k) {
    const Stage &s = qp.stages[k], &t = qp.stages[k - 1];
    cost_compared = k;
    cost_repeats = s.nx == t.nx && s.nu == t.nu && same(s.Q, t.Q, s.nx, s.nx) &&
                   same(s.R, t.R, s.nu, s.nu) && same(s.S, t.S, s.nu, s.nx);
  }
  return cost_repeats;
}

void Packing::choose_parts(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = to.stages[k];
  p.parts = 1;
  const int size = s.resultant_size;
  if (size <= 0 || starts_free(k) || k == qp.intervals() || s.nu % size != 0) return;
  const int parts = s.nu / size;
  if (parts < 2 || parts > max_parts || p.sweep.next < size) return;
  // Parts share neither cost nor rows.
  if (!rows_separate_parts(s, size)) return;
  const bool seen = k > 0 && to.stages[k - 1].parts == parts && has_same_cost_as_previous(k);
  if (!seen && !is_zero(s.S, 0, 0, s.nu, s.nx)) return;
  for (int part = 0; part + 1 < parts && !seen; ++part)
    if (!is_zero(s.R, (part + 1) * size, part * size, s.nu - (part + 1) * size, size)) return;
  if (!find_maps(k, parts)) return;
  p.parts = parts;
  p.split_kernel = kernel_for(split_kernels, &SplitKernel::size, size);
  ++to.reduced_stages;
}

// Finds T_p with B_p = B_1 T_p. Reuses those of the previous stage if they fit.
bool Packing::find_maps(int k, int parts) {
  const Stage& s = qp.stages[k];
  PackedStage& p = to.stages[k];
  const ResultantSizes sizes{p.sweep.next, s.resultant_size, parts};
  if (k > 0) {
    const PackedStage& before = to.stages[k - 1];
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

void Packing::dynamics(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = to.stages[k];
  SweepStage& w = p.sweep;
  const int n = w.nx + w.nu, next = w.next, states = k == 0 ? p.free_states : w.nx;
  if (next > s.b.size()) {
    ok = false;
    return;
  }
  if (k > 1) {
    const PackedStage& before = to.stages[k - 1];
    const Stage& t = qp.stages[k - 1];
    if (before.sweep.nx == w.nx && before.sweep.nu == w.nu && before.sweep.next == next &&
        same(s.A, t.A, next, s.nx) && same(s.B, t.B, next, w.nu)) {
      w.flow = before.sweep.flow;
      w.flow_transposed = before.sweep.flow_transposed;
      w.flow_rows = before.sweep.flow_rows;
      w.dense = before.sweep.dense;
      w.first_copied = before.sweep.first_copied;
      w.zero_begin = before.sweep.zero_begin;
      w.zero_end = before.sweep.zero_end;
      return;
    }
  }
  double* F = zeros(w.ld_next * n);
  double* Ft = zeros(w.ld * next);
  int* in_force = integers(2 * ((n + 3) / 4));
  if (!ok) return;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < next; ++i)
      Ft[j + i * w.ld] = F[i + j * w.ld_next] = j < states ? s.A(i, j) : s.B(i, j - states);
  w.flow = F;
  w.flow_transposed = Ft;
  w.flow_rows = in_force;
  find_copied_inputs(w);
  for (int j = 0; j < n; j += 4) {
    const auto is_zero_row = [&](int i) {
      for (int c = j; c < std::min(j + 4, n); ++c)
        if (F[i + c * w.ld_next] != 0.0) return false;
      return true;
    };
    int begin = 0, end = w.dense;
    while (begin < end && is_zero_row(begin)) ++begin;
    while (end > begin && is_zero_row(end - 1)) --end;
    in_force[j / 2] = begin;
    in_force[j / 2 + 1] = end;
  }
}

// A fixed start is known: its contribution is added to b and g.
void Packing::vectors(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = to.stages[k];
  const SweepStage& w = p.sweep;
  const int n = w.nx + w.nu, states = k == 0 ? p.free_states : w.nx, inputs = n - states;
  const int ld = padded(inputs), further = p.parts - 1;
  std::fill_n(p.b, w.ld_next, 0.0);
  for (int i = 0; i < w.next; ++i) p.b[i] = s.b[i];
  for (int j = 0; j < p.constant_states; ++j)
    for (int i = 0; i < w.next; ++i) p.b[i] += s.A(i, j) * qp.start[j];
  std::fill_n(p.g, w.ld, 0.0);
  for (int j = 0; j < n; ++j) p.g[j] = j < states ? s.q[j] : s.r[j - states];
  for (int j = 0; j < p.constant_states; ++j)
    for (int i = 0; i < inputs; ++i) p.g[i] += s.S(i, j) * qp.start[j];
  if (further > 0) std::fill_n(p.r, further * ld, 0.0);
  for (int part = 0; part < further; ++part)
    to_common_inputs(p.T_inverse, part, inputs, &s.r[(part + 1) * inputs], p.r + part * ld);
}

void Packing::hessian(int k) {
  const Stage& s = qp.stages[k];
  PackedStage& p = to.stages[k];
  const SweepStage& w = p.sweep;
  const int n = w.nx + w.nu, states = k == 0 ? p.free_states : w.nx, m = n - states;
  const int ld = padded(m), further = p.parts - 1;
  make_splits(k);
  if (!ok) return;
  if (k > 1) {
    const PackedStage& before = to.stages[k - 1];
    if (before.sweep.nx == w.nx && before.sweep.nu == w.nu && before.parts == p.parts &&
        (further == 0 || before.T == p.T) && has_same_cost_as_previous(k)) {
      p.H = before.H;
      p.outer = before.outer;
      p.R = before.R;
      return;
    }
  }
  double* H = zeros(w.ld * n);
  double* outer = further > 0 ? zeros(w.ld * n) : H;
  double* R = further > 0 ? zeros(p.parts * ld * m) : nullptr;
  if (!ok) return;
  for (int j = 0; j < states; ++j) {
    for (int i = 0; i < states; ++i) H[i + j * w.ld] = outer[i + j * w.ld] = s.Q(i, j);
    if (further == 0)
      for (int i = 0; i < m; ++i) H[states + i + j * w.ld] = H[j + (states + i) * w.ld] = s.S(i, j);
  }
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < m; ++i) {
      H[states + i + (states + j) * w.ld] = s.R(i, j);
      if (further > 0) R[i + j * ld] = s.R(i, j);
    }
  std::array<double, max_resultant_size> half;  // a column of R_p T_p^-1
  for (int part = 0; part < further; ++part)
    for (int c = 0; c < m; ++c) {
      const int first = (part + 1) * m;
      const double* right = p.T_inverse + (part * m + c) * ld;
      for (int i = 0; i < m; ++i) {
        half[i] = 0.0;
        for (int l = 0; l < m; ++l) half[i] += s.R(first + i, first + l) * right[l];
      }
      to_common_inputs(p.T_inverse, part, m, half.data(), R + (first + c) * ld);
    }
  p.H = H;
  p.outer = outer;
  p.R = R;
}

// Creates the splits that join the parts in the factorisation.
void Packing::make_splits(int k) {
  PackedStage& p = to.stages[k];
  const int m = p.sweep.nu, ld = padded(m), further = p.parts - 1;
  p.R_work = further > 0 ? numbers(p.parts * ld * m) : nullptr;
  p.splits = to.storage.splits.data() + (max_parts - 1) * k;
  for (int part = 0; part < further; ++part) {
    Split& split = p.splits[part];
    double* own = numbers(Split::size(m));
    if (!ok) return;
    split.before = part == 0 ? p.R_work : own;
    split.second = p.R_work + (part + 1) * ld * m;
    split.L = own + ld * m;
    split.Lt = split.L + ld * m;
    split.pivot = split.Lt + ld * m;
    split.difference = split.pivot + ld;
  }
}

}  // namespace saltus::qp
