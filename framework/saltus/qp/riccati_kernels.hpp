// One stage of the Riccati recursion: elimination of its inputs, and the backward and forward
// sweeps. Derivation: framework/design/riccati.md. The same source serves sizes known at compile
// time and sizes known only at run time (-1).
#pragma once

#include <type_traits>
#include <utility>

#include "saltus/qp/lanes.hpp"

namespace saltus::qp {

/// A size; a compile-time constant if N >= 0.
template <int N>
struct Extent {
  explicit constexpr Extent(int) {}
  constexpr operator int() const { return N; }
};
template <>
struct Extent<-1> {
  explicit constexpr Extent(int size) : n(size) {}
  constexpr operator int() const { return n; }
  int n;
};

// Calls step(i) for i = 0 ... N-1. For N >= 0 the loop is unrolled and every i is a constant.
template <int N, class Step>
SALTUS_INLINE void for_each(const Extent<N>& n, const Step& step) {
  if constexpr (N >= 0)
    [&]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) {
      (step(std::integral_constant<int, i>()), ...);
    }
  (std::make_integer_sequence<int, N>());
  else for (int i = 0; i < n; ++i) step(i);
}

/// Matrices are stored by columns, padded to whole vectors. Stage vector v = (x, u), n = nx + nu.
struct SweepStage {
  int nx = 0, nu = 0, next = 0;             ///< next: number of states of the next stage
  int ld = 0;                               ///< padded(nx + nu)
  int ld_next = 0;                          ///< padded(next)
  const double* flow = nullptr;             ///< [A B], next x n, leading dimension ld_next
  const double* flow_transposed = nullptr;  ///< n x next, leading dimension ld
  /// Rows of flow from this one on copy consecutive entries of v: previous inputs that are states.
  /// Equal to `next` if there are none.
  int dense = 0;
  int first_copied = 0;              ///< first of the copied entries
  int zero_begin = 0, zero_end = 0;  ///< zero columns of flow, in whole vectors
  /// First and end row of the nonzero dense rows, per group of four columns of flow.
  const int* flow_rows = nullptr;
  /// n x n, upper triangle. Before factor(): cost and barrier. After it: P in the leading nx x nx
  /// (both triangles); the columns behind it are then free for the previous stage.
  double* M = nullptr;
  double* L = nullptr;                  ///< ld x nu: unit upper factor, without its diagonal
  double* pivot = nullptr;              ///< nu: inverse pivots
  bool has_negative_curvature = false;  ///< set by factor() if a pivot was clearly negative
  double* p = nullptr;  ///< ld: gradient; after backward() gradient of the cost to go, with the
                        ///< eliminated inputs below it
};

/// A pivot this small relative to its initial diagonal is rounding error.
inline constexpr double lost_digits = 1e-15;
/// A pivot below minus this, relative to 1 + its initial diagonal, is more than rounding error.
inline constexpr double clearly_negative = 1e-12;

enum class Update { set, add, subtract };

// Computes V vectors x C columns of out = [from +/-] A B, B(i, j) = B[i * step_i + j * step_j].
template <Update update, int V, int C>
SALTUS_INLINE void tile(int depth, const double* A, int lda, const double* B, int step_i,
                        int step_j, const double* from, double* out, int ldo) {
  Lanes acc[C][V];
  for (int c = 0; c < C; ++c)
    for (int v = 0; v < V; ++v)
      acc[c][v] = update == Update::set ? Lanes{} : load(from + c * ldo + v * lanes);
#pragma GCC unroll 3
  for (int i = 0; i < depth; ++i) {
    Lanes a[V];
    for (int v = 0; v < V; ++v) a[v] = load(A + i * lda + v * lanes);
    for (int c = 0; c < C; ++c) {
      const Lanes b = broadcast(B[i * step_i + c * step_j]);
      for (int v = 0; v < V; ++v)
        if constexpr (update == Update::subtract)
          acc[c][v] -= a[v] * b;
        else
          acc[c][v] += a[v] * b;
    }
  }
  for (int c = 0; c < C; ++c)
    for (int v = 0; v < V; ++v) store(out + c * ldo + v * lanes, acc[c][v]);
}

// Computes C columns of any height. Tiles are as high as the registers allow.
template <Update update, int C>
SALTUS_INLINE void strip(int vectors, int depth, const double* A, int lda, const double* B,
                         int step_i, int step_j, const double* from, double* out, int ldo) {
  constexpr int high = lanes == 8 || C < 3 ? 4 : 3;
  int v = 0;
  const auto next = [&]<int V>() __attribute__((always_inline)) {
    tile<update, V, C>(depth, A + v * lanes, lda, B, step_i, step_j, from + v * lanes,
                       out + v * lanes, ldo);
    v += V;
  };
  while (vectors - v > high + 1 || vectors - v == high) next.template operator()<high>();
  if (vectors - v >= 4) next.template operator()<2>();
  if (vectors - v == 3) next.template operator()<3>();
  if (vectors - v == 2) next.template operator()<2>();
  if (vectors - v == 1) next.template operator()<1>();
}

// Computes the columns that remain after strips of four.
template <Update update>
SALTUS_INLINE void last_strip(int columns, int vectors, int depth, const double* A, int lda,
                              const double* B, int step_i, int step_j, const double* from,
                              double* out, int ldo) {
  if (columns == 3) strip<update, 3>(vectors, depth, A, lda, B, step_i, step_j, from, out, ldo);
  if (columns == 2) strip<update, 2>(vectors, depth, A, lda, B, step_i, step_j, from, out, ldo);
  if (columns == 1) strip<update, 1>(vectors, depth, A, lda, B, step_i, step_j, from, out, ldo);
}

/// out = A B for out with `columns` columns of `rows` entries.
SALTUS_INLINE void multiply(int rows, int columns, int depth, const double* A, int lda,
                            const double* B, int step_i, int step_j, double* out, int ldo) {
  const int vectors = padded(rows) / lanes;
  int j = 0;
  for (; j + 4 <= columns; j += 4)
    strip<Update::set, 4>(vectors, depth, A, lda, B + j * step_j, step_i, step_j, out + j * ldo,
                          out + j * ldo, ldo);
  last_strip<Update::set>(columns - j, vectors, depth, A, lda, B + j * step_j, step_i, step_j,
                          out + j * ldo, out + j * ldo, ldo);
}

/// Like multiply(), for a B whose columns, in groups of four, are nonzero only in rows in_force[0]
/// to in_force[1].
SALTUS_INLINE void multiply_within(int rows, int columns, const int* in_force, const double* A,
                                   int lda, const double* B, int ldb, double* out, int ldo) {
  const int vectors = padded(rows) / lanes;
  int j = 0;
  for (; j + 4 <= columns; j += 4, in_force += 2)
    strip<Update::set, 4>(vectors, in_force[1] - in_force[0], A + in_force[0] * lda, lda,
                          B + in_force[0] + j * ldb, 1, ldb, out + j * ldo, out + j * ldo, ldo);
  if (j < columns)
    last_strip<Update::set>(columns - j, vectors, in_force[1] - in_force[0], A + in_force[0] * lda,
                            lda, B + in_force[0] + j * ldb, 1, ldb, out + j * ldo, out + j * ldo,
                            ldo);
}

/// Computes the upper triangle of a symmetric result, out = [from +/-] A B.
template <Update update>
SALTUS_INLINE void multiply_upper(int columns, int depth, const double* A, int lda, const double* B,
                                  int step_i, int step_j, const double* from, double* out,
                                  int ldo) {
  int j = 0;
  for (; j + 4 <= columns; j += 4)
    strip<update, 4>(padded(j + 4) / lanes, depth, A, lda, B + j * step_j, step_i, step_j,
                     from + j * ldo, out + j * ldo, ldo);
  last_strip<update>(columns - j, padded(columns) / lanes, depth, A, lda, B + j * step_j, step_i,
                     step_j, from + j * ldo, out + j * ldo, ldo);
}

/// Computes out = from + A B, where the products of rows and columns from `zero_begin` to
/// `zero_end` (in whole strips and vectors) are zero.
template <int N>
SALTUS_INLINE void add_upper_without(int zero_begin, int zero_end, const Extent<N>& columns,
                                     int depth, const double* A, int lda, const double* B, int ldb,
                                     const double* from, double* out, int ldo) {
  constexpr int strips = N < 0 ? -1 : (N + 3) / 4;
  const int first = zero_begin / lanes, last = zero_end / lanes;
  for_each(
      Extent<strips>((columns + 3) / 4), [&](int index) __attribute__((always_inline)) {
        const int j = 4 * index, width = columns - j < 4 ? columns - j : 4;
        const int vectors = padded(j + width) / lanes;
        const double *b = B + j * ldb, *given = from + j * ldo;
        double* to = out + j * ldo;
        const auto copied = [&](int begin, int end) __attribute__((always_inline)) {
          for (int c = 0; c < width; ++c)
            for (int v = begin * lanes; v < end * lanes; v += lanes)
              store(to + c * ldo + v, load(given + c * ldo + v));
        };
        const auto part = [&](int begin, int end) __attribute__((always_inline)) {
          const int v = begin * lanes;
          if (width == 4)
            strip<Update::add, 4>(end - begin, depth, A + v, lda, b, 1, ldb, given + v, to + v,
                                  ldo);
          else
            last_strip<Update::add>(width, end - begin, depth, A + v, lda, b, 1, ldb, given + v,
                                    to + v, ldo);
        };
        if (j >= zero_begin && j + width <= zero_end) {
          copied(0, vectors);
        } else if (vectors <= last || first == last) {
          part(0, vectors);
        } else {
          part(0, first);
          copied(first, last);
          part(last, vectors);
        }
      });
}

// Computes V vectors of y (+/-)= A x. Two independent sums avoid the latency of dependent
// additions.
template <Update update, int V>
SALTUS_INLINE void vector_tile(int columns, const double* A, int lda, const double* x, double* y) {
  Lanes even[V], odd[V];
  for (int v = 0; v < V; ++v) {
    even[v] = update == Update::set ? Lanes{} : load(y + v * lanes);
    odd[v] = Lanes{};
  }
  int j = 0;
  for (; j + 2 <= columns; j += 2) {
    const Lanes a = broadcast(x[j]), b = broadcast(x[j + 1]);
    for (int v = 0; v < V; ++v) {
      even[v] += load(A + j * lda + v * lanes) * a;
      odd[v] += load(A + (j + 1) * lda + v * lanes) * b;
    }
  }
  if (j < columns) {
    const Lanes a = broadcast(x[j]);
    for (int v = 0; v < V; ++v) even[v] += load(A + j * lda + v * lanes) * a;
  }
  for (int v = 0; v < V; ++v) store(y + v * lanes, even[v] + odd[v]);
}

/// y (+)= A x.
template <Update update>
SALTUS_INLINE void multiply_vector(int rows, int columns, const double* A, int lda, const double* x,
                                   double* y) {
  const int vectors = padded(rows) / lanes;
  int v = 0;
  for (; v + 4 <= vectors; v += 4)
    vector_tile<update, 4>(columns, A + v * lanes, lda, x, y + v * lanes);
  A += v * lanes;
  y += v * lanes;
  if (vectors - v == 3) vector_tile<update, 3>(columns, A, lda, x, y);
  if (vectors - v == 2) vector_tile<update, 2>(columns, A, lda, x, y);
  if (vectors - v == 1) vector_tile<update, 1>(columns, A, lda, x, y);
}

/// Copied entries and zero columns of the flow (see the fields of SweepStage), known at run time
/// only.
struct RuntimeCopiedInputs {
  explicit RuntimeCopiedInputs(const SweepStage& s)
      : dense(s.dense), first(s.first_copied), zero_begin(s.zero_begin), zero_end(s.zero_end) {}
  const int dense, first, zero_begin, zero_end;
};
/// All NU inputs become the last states of the next stage. Its NN - NU other states do not depend
/// on the previous inputs, which are the last states of this stage.
template <int NX, int NU, int NN>
struct CopiedInputs {
  explicit constexpr CopiedInputs(const SweepStage&) {}
  static constexpr int dense = NN - NU, first = NX;
  static constexpr int in_whole_vectors = NX / lanes * lanes;
  static constexpr int zero_begin = in_whole_vectors > padded(dense) ? padded(dense) : 0;
  static constexpr int zero_end = zero_begin > 0 ? in_whole_vectors : 0;
};

// Products with a flow some of whose rows copy entries of v.

// Computes to += from, entry by entry.
SALTUS_INLINE void add_entries(int count, const double* from, double* to) {
  int i = 0;
  for (; i + lanes <= count; i += lanes)
    store_loose(to + i, load_loose(to + i) + load_loose(from + i));
  for (; i < count; ++i) to[i] += from[i];
}

// Computes M = from + flow' P flow. `work` holds the product of P with the dense rows of the flow.
template <class HandedOn, int N>
SALTUS_INLINE void assemble_with_copies(SweepStage& s, const HandedOn& handed, const Extent<N>& n,
                                        int next, const double* from, const double* P, int ld_P,
                                        double* work) {
  const int count = next - handed.dense, ld = padded(n), ld_next = padded(next);
  for (int i = 0; i < count; ++i) {
    double* to = work + (handed.first + i) * ld_next;
    for (int v = 0; v < ld_next; v += lanes)
      store(to + v, load(to + v) + load(P + (handed.dense + i) * ld_P + v));
  }
  add_upper_without(handed.zero_begin, handed.zero_end, n, handed.dense, s.flow_transposed, ld,
                    work, ld_next, from, s.M, ld);
  for (int j = handed.first; j < n; ++j)
    add_entries(j - handed.first < count ? j - handed.first + 1 : count,
                work + handed.dense + j * ld_next, s.M + handed.first + j * ld);
}

// Computes out += flow v.
template <class HandedOn>
SALTUS_INLINE void add_flow_with_copies(const SweepStage& s, const HandedOn& handed, int n,
                                        int next, const double* v, double* out) {
  // The last vector of the dense rows may contain further rows, which are included.
  const int rows = padded(handed.dense), ld_next = padded(next), after = handed.zero_end;
  multiply_vector<Update::add>(rows, handed.zero_begin, s.flow, ld_next, v, out);
  multiply_vector<Update::add>(rows, n - after, s.flow + after * ld_next, ld_next, v + after, out);
  if (next > rows) add_entries(next - rows, v + handed.first + rows - handed.dense, out + rows);
}

// Computes out (+)= flow' x.
template <Update update, class HandedOn>
SALTUS_INLINE void flow_transposed_with_copies(const SweepStage& s, const HandedOn& handed, int n,
                                               int next, const double* x, double* out) {
  multiply_vector<update>(n, handed.dense, s.flow_transposed, padded(n), x, out);
  add_entries(next - handed.dense, x + handed.dense, out + handed.first);
}

// The same for run-time sizes. Not inlined, to keep the callers small.
[[gnu::noinline]] inline void assemble_with_runtime_copies(SweepStage& s, int n, const double* from,
                                                           const double* P, int ld_P,
                                                           double* work) {
  assemble_with_copies(s, RuntimeCopiedInputs(s), Extent<-1>(n), s.next, from, P, ld_P, work);
}
[[gnu::noinline]] inline void add_flow_with_runtime_copies(const SweepStage& s, int n,
                                                           const double* v, double* out) {
  add_flow_with_copies(s, RuntimeCopiedInputs(s), n, s.next, v, out);
}
template <Update update>
[[gnu::noinline]] void flow_transposed_with_runtime_copies(const SweepStage& s, int n,
                                                           const double* x, double* out) {
  flow_transposed_with_copies<update>(s, RuntimeCopiedInputs(s), n, s.next, x, out);
}

/// Operations of the recursion at one stage. With `copies_inputs`, the flow is CopiedInputs<NX, NU,
/// NN>.
template <int NX, int NU, int NN, bool copies_inputs = false>
struct RiccatiStage {
  using Handed = CopiedInputs<NX, NU, NN>;

  /// Computes M = from + flow' P flow (upper triangles) and adds `on_states` and `on_inputs` to its
  /// diagonal. P: next x next, leading dimension ld_P. `work`: ld_next x n.
  static void assemble(SweepStage& s, const double* from, double on_states, double on_inputs,
                       const double* P, int ld_P, double* work) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu, ld = padded(n), ld_next = padded(nn);
    if (nn > 0) {
      multiply_within(nn, n, s.flow_rows, P, ld_P, s.flow, ld_next, work, ld_next);
      if constexpr (copies_inputs)
        assemble_with_copies(s, Handed(s), Extent<NX + NU>(n), nn, from, P, ld_P, work);
      else if (s.dense == nn)
        multiply_upper<Update::add>(n, nn, s.flow_transposed, ld, work, 1, ld_next, from, s.M, ld);
      else
        assemble_with_runtime_copies(s, n, from, P, ld_P, work);
    } else {
      for (int i = 0; i < ld * n; i += lanes) store(s.M + i, load(from + i));
    }
    for (int i = 0; i < nx; ++i) s.M[i * (ld + 1)] += on_states;
    for (int i = nx; i < n; ++i) s.M[i * (ld + 1)] += on_inputs;
  }

  // Computes out += flow v.
  static SALTUS_INLINE void add_flow(const SweepStage& s, const double* v, double* out) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    if constexpr (copies_inputs)
      add_flow_with_copies(s, Handed(s), nx + nu, nn, v, out);
    else if (s.dense == nn)
      multiply_vector<Update::add>(nn, nx + nu, s.flow, padded(nn), v, out);
    else
      add_flow_with_runtime_copies(s, nx + nu, v, out);
  }

  // Computes out (+)= flow' x.
  template <Update update>
  static SALTUS_INLINE void flow_transposed_times(const SweepStage& s, const double* x,
                                                  double* out) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu;
    if constexpr (copies_inputs)
      flow_transposed_with_copies<update>(s, Handed(s), n, nn, x, out);
    else if (s.dense == nn)
      multiply_vector<update>(n, nn, s.flow_transposed, padded(n), x, out);
    else
      flow_transposed_with_runtime_copies<update>(s, n, x, out);
  }

  // Updates `count` columns of M, which belong to the inputs from `first` on. Subtracts the
  // contributions of the `further` eliminated inputs from `behind` on.
  static void subtract_eliminated_inputs(SweepStage& s, int first, int count, int behind,
                                         int further) {
    const int column = s.nx + first, ld = padded(s.nx + s.nu);
    const double* factors = s.L + behind * ld;
    const double* rows = s.M + (s.nx + behind) * ld + column;
    double* out = s.M + column * ld;
    const int vectors = padded(column + count) / lanes;
    if (count == 4)
      strip<Update::subtract, 4>(vectors, further, factors, ld, rows, ld, 1, out, out, ld);
    else
      last_strip<Update::subtract>(count, vectors, further, factors, ld, rows, ld, 1, out, out, ld);
  }

  // Eliminates input j, whose initial diagonal in M was `diagonal`. The contributions of later
  // inputs before `behind` are not yet subtracted from its column.
  static SALTUS_INLINE void eliminate_input(SweepStage& s, int nx, int j, int behind, int ld,
                                            double diagonal, double least_pivot) {
    double* column = s.M + (nx + j) * ld;
    double* factor = s.L + j * ld;
    strip<Update::subtract, 1>(padded(nx + j + 1) / lanes, behind - 1 - j, factor + ld, ld,
                               column + ld + nx + j, ld, 0, column, column, ld);
    double pivot = column[nx + j];
    // A stiff direction of which only rounding error is left does not move in this step.
    if (!(pivot > least_pivot + lost_digits * diagonal)) {
      if (pivot < -clearly_negative * (1.0 + (diagonal < 0.0 ? -diagonal : diagonal)))
        s.has_negative_curvature = true;
      pivot = diagonal > least_pivot ? diagonal : least_pivot;
    }
    const double inverse = 1.0 / pivot;
    s.pivot[j] = inverse;
    // Entries from the diagonal down must not contribute to the sweeps.
    for (int i = nx + j; i < padded(nx + j + 1); ++i) column[i] = 0.0;
    for (int v = 0; v < padded(nx + j); v += lanes) store(factor + v, load(column + v) * inverse);
  }

  /// Eliminates the inputs from M. Replaces pivots at or below `least_pivot`.
  static void eliminate(SweepStage& s, double least_pivot) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const int n = nx + nu, ld = padded(n);
    if constexpr (NU < 0) {
      // Four columns at a time: the contributions of the inputs behind them are one product.
      for (int behind = nu; behind > 0;) {
        const int begin = behind > 4 ? behind - 4 : 0;
        double diagonal[4];
        for (int j = begin; j < behind; ++j) diagonal[j - begin] = s.M[(nx + j) * (ld + 1)];
        if (behind < nu) subtract_eliminated_inputs(s, begin, behind - begin, behind, nu - behind);
        for (int j = behind - 1; j >= begin; --j)
          eliminate_input(s, nx, j, behind, ld, diagonal[j - begin], least_pivot);
        behind = begin;
      }
    } else {
      for_each(
          nu, [&](int eliminated) __attribute__((always_inline)) {
            const int j = nu - 1 - eliminated;
            eliminate_input(s, nx, j, nu, ld, s.M[(nx + j) * (ld + 1)], least_pivot);
          });
    }
    if (nx > 0 && nu > 0)
      multiply_upper<Update::subtract>(nx, nu, s.L, ld, s.M + nx * ld, ld, 1, s.M, s.M, ld);
    for (int j = 1; j < nx; ++j)
      for (int i = 0; i < j; ++i) s.M[j + i * ld] = s.M[i + j * ld];
  }

  /// Computes the gradient of the cost to go in s.p. `gradient` may be s.p itself. `gap`: defect A
  /// x + B u + b - x_next. `P`, `p`: of the next stage. `work`: ld_next.
  static void backward(SweepStage& s, const double* gradient, const double* P, int ld_P,
                       const double* p, const double* gap, double* work) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu, ld = padded(n);
    if (gradient != s.p)
      for (int v = 0; v < ld; v += lanes) store(s.p + v, load(gradient + v));
    if (nn > 0) {
      for (int v = 0; v < padded(nn); v += lanes) store(work + v, load(p + v));
      multiply_vector<Update::add>(nn, nn, P, ld_P, gap, work);
      flow_transposed_times<Update::add>(s, work, s.p);
    }
    for (int j = nu - 1; j >= 0; --j) {
      const double h = s.p[nx + j];
      for (int v = 0; v < padded(nx + j); v += lanes)
        store(s.p + v, load(s.p + v) - load(s.L + j * ld + v) * h);
    }
  }

  // Computes u in v, given x. Four inputs at a time: first the whole vectors before them, then the
  // rest.
  static void forward_inputs(const SweepStage& s, double* v) {
    const int nx = s.nx, nu = s.nu, ld = padded(nx + nu);
    const auto some = [&]<int count>(int j) __attribute__((always_inline)) {
      const double* factor = s.L + j * ld;
      const int whole = (nx + j) / lanes * lanes;
      Lanes dots[count] = {};
      for (int i = 0; i < whole; i += lanes) {
        const Lanes before = load(v + i);
        for (int c = 0; c < count; ++c) dots[c] += load(factor + c * ld + i) * before;
      }
      for (int c = 0; c < count; ++c) {
        double total = sum(dots[c]);
        for (int i = whole; i < nx + j + c; ++i) total += factor[c * ld + i] * v[i];
        v[nx + j + c] = -s.p[nx + j + c] * s.pivot[j + c] - total;
      }
    };
    int j = 0;
    for (; j + 4 <= nu; j += 4) some.template operator()<4>(j);
    for (; j < nu; ++j) some.template operator()<1>(j);
  }

  /// v: x on entry, with u on return. Also computes the next x and the multipliers of the dynamics.
  static void forward(const SweepStage& s, const double* P, int ld_P, const double* p,
                      const double* gap, double* v, double* v_next, double* costate) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu, ld = padded(n), ld_next = padded(nn);
    // The part of x comes first: there the products of the inputs are independent.
    int j = 0;
    if constexpr (NX > 0 && NU > 0) {
      // Inputs are zero meanwhile, so that the products may run to the end of a vector.
      for (int i = nx; i < padded(nx); ++i) v[i] = 0.0;
      Lanes inputs[padded(NU) / lanes];
      for (int group = 0; group < padded(nu); group += lanes) {
        Lanes dots[lanes] = {};
        for (int l = 0; l < lanes && group + l < nu; ++l)
          for (int i = 0; i < nx; i += lanes)
            dots[l] += load(s.L + (group + l) * ld + i) * load(v + i);
        inputs[group / lanes] = -sums(dots);
      }
      for (; j < nu; ++j) v[nx + j] = inputs[j / lanes][j % lanes] - s.p[nx + j] * s.pivot[j];
    }
    if constexpr (NU < 0) {
      forward_inputs(s, v);
    } else {
      for (; j < nu; ++j) {
        const double* factor = s.L + j * ld;
        Lanes dot{};
        int i = 0;
        for (; i + lanes <= nx; i += lanes) dot += load(factor + i) * load(v + i);
        double total = sum(dot);
        for (; i < nx; ++i) total += factor[i] * v[i];
        v[nx + j] = -s.p[nx + j] * s.pivot[j] - total;
      }
      for_each(
          nu, [&](int later) __attribute__((always_inline)) {
            double total = v[nx + later];
            for (int i = 0; i < later; ++i) total -= s.L[later * ld + nx + i] * v[nx + i];
            v[nx + later] = total;
          });
    }
    for (int i = n; i < ld; ++i) v[i] = 0.0;
    if (nn == 0) return;
    for (int i = 0; i < ld_next; i += lanes) store(v_next + i, load(gap + i));
    add_flow(s, v, v_next);
    for (int i = nn; i < ld_next; ++i) v_next[i] = 0.0;
    for (int i = 0; i < ld_next; i += lanes) store(costate + i, load(p + i));
    multiply_vector<Update::add>(nn, nn, P, ld_P, v_next, costate);
    for (int i = nn; i < ld_next; ++i) costate[i] = 0.0;
  }

  /// Computes gradient = [g] + H v - [arriving] + force, force = flow' costate and gap = [b] + flow
  /// u - v_next. u is v or the resultant that the dynamics see. `arriving` is the costate of the
  /// previous stage. Null arguments in brackets are omitted.
  static void products(const SweepStage& s, const double* H, const double* g, const double* b,
                       const double* v, const double* u, const double* arriving,
                       const double* costate, const double* v_next, double* gradient, double* force,
                       double* gap) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu, ld = padded(n), ld_next = padded(nn);
    for (int i = 0; i < ld; i += lanes) store(gradient + i, g != nullptr ? load(g + i) : Lanes{});
    multiply_vector<Update::add>(n, n, H, ld, v, gradient);
    for (int i = 0; i < nx && arriving != nullptr; ++i) gradient[i] -= arriving[i];
    if (nn == 0) return;
    flow_transposed_times<Update::set>(s, costate, force);
    for (int i = 0; i < ld; i += lanes) store(gradient + i, load(gradient + i) + load(force + i));
    for (int i = 0; i < ld_next; i += lanes) store(gap + i, b != nullptr ? load(b + i) : Lanes{});
    add_flow(s, u, gap);
    int i = 0;
    for (; i + lanes <= nn; i += lanes) store(gap + i, load(gap + i) - load(v_next + i));
    for (; i < nn; ++i) gap[i] -= v_next[i];
    for (; i < ld_next; ++i) gap[i] = 0.0;
  }
};

/// Function pointers for one combination of sizes.
struct RiccatiKernel {
  int nx, nu, next;    ///< -1: any
  bool copies_inputs;  ///< only for stages whose inputs are exactly the copied last states of the
                       ///< next stage
  int zero_begin, zero_end;  ///< with `copies_inputs`: columns of flow that must be zero
  void (*assemble)(SweepStage&, const double*, double, double, const double*, int, double*);
  void (*eliminate)(SweepStage&, double);
  void (*backward)(SweepStage&, const double*, const double*, int, const double*, const double*,
                   double*);
  void (*forward)(const SweepStage&, const double*, int, const double*, const double*, double*,
                  double*, double*);
  void (*products)(const SweepStage&, const double*, const double*, const double*, const double*,
                   const double*, const double*, const double*, const double*, double*, double*,
                   double*);
};

/// Kernel for stages of these sizes. With `copies_inputs`, only for stages whose inputs are copied
/// to the last states of the next stage, as with costs or bounds on input changes.
template <int NX, int NU, int NN, bool copies_inputs = false>
constexpr RiccatiKernel riccati_kernel() {
  using S = RiccatiStage<NX, NU, NN, copies_inputs>;
  using Handed = CopiedInputs<NX, NU, NN>;
  return {NX,
          NU,
          NN,
          copies_inputs,
          copies_inputs ? Handed::zero_begin : 0,
          copies_inputs ? Handed::zero_end : 0,
          &S::assemble,
          &S::eliminate,
          &S::backward,
          &S::forward,
          &S::products};
}

}  // namespace saltus::qp
